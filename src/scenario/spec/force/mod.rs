//! `[[force]]`: what acts on the robot besides gravity and the floor. One file per type.

mod constant;
mod joint_friction;
mod push;
mod ramp;
mod spring;

pub use constant::ConstantForce;
pub use joint_friction::JointFrictionForce;
pub use push::{Profile, PushForce};
pub use ramp::RampForce;
pub use spring::{AnchorSpec, PathShape, SineSpec, SpringForce, WaypointSpec};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::tagged::tagged;

tagged! {
    /// One external force.
    ForceSpec, "force" {
        /// A force on a link for a time, with a profile.
        "push" => Push(PushForce),
        /// A force on a link throughout, or for a time.
        "constant" => Constant(ConstantForce),
        /// Friction in joints, beside what the robot's files give.
        "joint-friction" => JointFriction(JointFrictionForce),
        /// A force on a link that rises linearly and stays.
        "ramp" => Ramp(RampForce),
        /// A spring and damper to an anchor that may move.
        "spring" => Spring(SpringForce),
    }
}

/// Axes that a force and a moment are given in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ForceFrame {
    /// The world's.
    #[default]
    World,
    /// The link's, turning with it.
    Link,
}
