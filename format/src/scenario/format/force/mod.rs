//! `[[force]]`: external forces on the robot and on objects. One file per type.

mod carried_object;
mod constant;
mod drag;
mod joint_friction;
mod push;
mod ramp;
mod random_pushes;
mod script_force;
mod spring;

pub use carried_object::CarriedObject;
pub use constant::ConstantForce;
pub use drag::DragForce;
pub use joint_friction::JointFrictionForce;
pub use push::{Profile, PushForce};
pub use ramp::RampForce;
pub use random_pushes::{Directions, RandomPushes};
pub use script_force::ScriptForce;
pub use spring::{AnchorSpec, PathShape, SineSpec, SpringForce, WaypointSpec};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::tagged::tagged;

tagged! {
    /// One external force.
    ForceSpec, "force" {
        /// A force on a link for a time, with a profile.
        "push" => Push(PushForce),
        /// A force on a link throughout, or for a time.
        "constant" => Constant(ConstantForce),
        /// Friction in joints, added to that of the robot's files.
        "joint-friction" => JointFriction(JointFrictionForce),
        /// A force on a link that rises linearly and then stays constant.
        "ramp" => Ramp(RampForce),
        /// A spring and damper to an anchor that may move.
        "spring" => Spring(SpringForce),
        /// Pushes drawn at random.
        "random-pushes" => RandomPushes(RandomPushes),
        /// Resistance of the air.
        "drag" => Drag(DragForce),
        /// An object that a link holds for a time.
        "carried-object" => CarriedObject(CarriedObject),
        /// Forces computed by a script.
        "script" => Script(ScriptForce),
    }
}

impl ForceSpec {
    /// The file that the key `file` names, if the type has that key.
    pub fn file(&self) -> Option<&str> {
        match self {
            ForceSpec::Script(script) => Some(&script.file),
            _ => None,
        }
    }
}

/// Axes of a force and a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ForceFrame {
    /// The world's axes.
    #[default]
    World,
    /// The axes of the link, or of the end effector if one is named; they rotate with it.
    Link,
}

/// The link or end effector on which an entry acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grip<'a> {
    /// A link by name.
    pub link: Option<&'a str>,
    /// An end effector by name.
    pub end_effector: Option<&'a str>,
}

impl ForceSpec {
    /// The one link or end effector that the entry acts on, for types that act on one.
    pub fn grip(&self) -> Option<Grip<'_>> {
        let (link, end_effector) = match self {
            ForceSpec::Push(push) => (&push.link, &push.end_effector),
            ForceSpec::Constant(constant) => (&constant.link, &constant.end_effector),
            ForceSpec::Ramp(ramp) => (&ramp.link, &ramp.end_effector),
            ForceSpec::Spring(spring) => (&spring.link, &spring.end_effector),
            ForceSpec::CarriedObject(object) => (&object.link, &object.end_effector),
            ForceSpec::JointFriction(_) | ForceSpec::RandomPushes(_) | ForceSpec::Drag(_) | ForceSpec::Script(_) => {
                return None;
            }
        };
        Some(Grip { link: link.as_deref(), end_effector: end_effector.as_deref() })
    }

    /// The object that the entry acts on; none for the robot.
    pub fn object(&self) -> Option<&str> {
        let object = match self {
            ForceSpec::Push(push) => &push.object,
            ForceSpec::Constant(constant) => &constant.object,
            ForceSpec::Ramp(ramp) => &ramp.object,
            ForceSpec::Spring(spring) => &spring.object,
            ForceSpec::RandomPushes(pushes) => &pushes.object,
            ForceSpec::Drag(drag) => &drag.object,
            ForceSpec::Script(script) => &script.object,
            ForceSpec::JointFriction(friction) => &friction.object,
            ForceSpec::CarriedObject(_) => &None,
        };
        object.as_deref()
    }
}
