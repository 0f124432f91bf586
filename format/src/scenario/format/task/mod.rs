//! `[[task]]`: sources of joint commands. One file per type.

mod balance;
mod balance_force;
mod balance_position;
mod gravity_compensation;
mod mocap;
mod playback;
mod policy;
mod posture;
mod script_task;
mod sine;
mod squat;
mod walk;

pub use balance::{BalanceChange, BalanceControl, BalanceTask};
pub use balance_force::{Contacts, ForceBalance, ForceBalanceChange, Gains};
pub use balance_position::{PositionBalance, PositionBalanceChange};
pub use gravity_compensation::{CompensationChange, GravityCompensationTask};
pub use mocap::{MocapTarget, MocapTask};
pub use playback::{Ends, PlaybackChange, PlaybackTask, Recorded};
pub use policy::{
    PolicyAction, PolicyChange, PolicyMode, PolicyNumbers, PolicyObservation, PolicyState, PolicyTask, PolicyTerm,
};
pub use posture::PostureTask;
pub use script_task::ScriptTask;
pub use sine::{SineChange, SineJoint, SineJointChange, SineTask};
pub use squat::SquatTask;
pub use walk::WalkTask;

use crate::scenario::format::tagged::tagged;

tagged! {
    /// One task. Where tasks overlap in time, the later one in the file commands a joint.
    TaskSpec, "task" {
        /// Moves joints to a posture.
        "posture" => Posture(PostureTask),
        /// Keeps the centre of mass above the soles.
        "balance" => Balance(BalanceTask),
        /// Carries the robot and yields to pushes.
        "gravity-compensation" => GravityCompensation(GravityCompensationTask),
        /// Runs a script.
        "script" => Script(ScriptTask),
        /// Moves joints sinusoidally.
        "sine" => Sine(SineTask),
        /// Plays a motion file.
        "playback" => Playback(PlaybackTask),
        /// Follows captured motion.
        "mocap" => Mocap(MocapTask),
        /// Bends the legs and rises again.
        "squat" => Squat(SquatTask),
        /// Walks, or steps on the spot.
        "walk" => Walk(WalkTask),
        /// Runs a neural network in an ONNX file.
        "policy" => Policy(PolicyTask),
    }
}

impl TaskSpec {
    /// The file that the key `file` names, if the type has that key.
    pub fn file(&self) -> Option<&str> {
        match self {
            TaskSpec::Playback(playback) => Some(&playback.file),
            TaskSpec::Mocap(mocap) => Some(&mocap.file),
            TaskSpec::Script(script) => Some(&script.file),
            TaskSpec::Policy(policy) => Some(&policy.file),
            _ => None,
        }
    }
}
