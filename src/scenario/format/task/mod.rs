//! `[[task]]`: what the robot is told to do. One file per type.

mod balance;
mod balance_force;
mod balance_position;
mod gravity_compensation;
mod mocap;
mod playback;
mod posture;
mod script;
mod sine;
mod squat;
mod walk;

pub use balance::{BalanceChange, BalanceControl, BalanceTask};
pub use balance_force::{Contacts, ForceBalance, ForceBalanceChange, Gains};
pub use balance_position::{PositionBalance, PositionBalanceChange};
pub use gravity_compensation::{CompensationChange, GravityCompensationTask};
pub use mocap::{MocapTarget, MocapTask};
pub use playback::{Ends, PlaybackChange, PlaybackTask, Recorded};
pub use posture::PostureTask;
pub use script::ScriptTask;
pub use sine::{SineChange, SineJoint, SineJointChange, SineTask};
pub use squat::SquatTask;
pub use walk::WalkTask;

use crate::scenario::format::tagged::tagged;

tagged! {
    /// One task. Where tasks overlap in time, later ones in the file win per joint.
    TaskSpec, "task" {
        /// Move joints to a posture.
        "posture" => Posture(PostureTask),
        /// Keep the centre of mass above the soles.
        "balance" => Balance(BalanceTask),
        /// Hold the robot up and give way to every push.
        "gravity-compensation" => GravityCompensation(GravityCompensationTask),
        /// What a script says.
        "script" => Script(ScriptTask),
        /// Swing joints sinusoidally.
        "sine" => Sine(SineTask),
        /// Play a motion file.
        "playback" => Playback(PlaybackTask),
        /// Follow captured motion.
        "mocap" => Mocap(MocapTask),
        /// Bend the legs and rise again.
        "squat" => Squat(SquatTask),
        /// Walk, or step in place.
        "walk" => Walk(WalkTask),
    }
}

impl TaskSpec {
    /// The file that the key `file` names, if the type has that key.
    pub fn file(&self) -> Option<&str> {
        match self {
            TaskSpec::Playback(playback) => Some(&playback.file),
            TaskSpec::Mocap(mocap) => Some(&mocap.file),
            TaskSpec::Script(script) => Some(&script.file),
            _ => None,
        }
    }
}
