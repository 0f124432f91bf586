//! `[[task]]`: what the robot is told to do. One file per type.

mod balance;
mod balance_force;
mod gravity_compensation;
mod posture;
mod script;

pub use balance::{BalanceControl, BalanceTask};
pub use balance_force::{Contacts, ForceBalance, Gains};
pub use gravity_compensation::GravityCompensationTask;
pub use posture::PostureTask;
pub use script::ScriptTask;
mod mocap;
mod playback;
mod sine;

pub use mocap::{MocapTarget, MocapTask};
pub use playback::{Ends, PlaybackChange, PlaybackTask, Recorded};
pub use sine::{SineChange, SineJoint, SineJointChange, SineTask};

use super::tagged::tagged;

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
    }
}

impl TaskSpec {
    /// The file that the key `file` names, if the type has that key.
    pub fn file(&self) -> Option<&str> {
        match self {
            TaskSpec::Playback(playback) => Some(&playback.file),
            TaskSpec::Mocap(mocap) => Some(&mocap.file),
            TaskSpec::Script(script) => Some(&script.file),
            TaskSpec::Posture(_) | TaskSpec::Sine(_) | TaskSpec::Balance(_) | TaskSpec::GravityCompensation(_) => None,
        }
    }
}
