//! `[[task]]`: what the robot is told to do. One file per type.

mod mocap;
mod playback;
mod posture;
mod sine;

pub use mocap::{MocapTarget, MocapTask};
pub use playback::{Ends, PlaybackChange, PlaybackTask, Recorded};
pub use posture::PostureTask;
pub use sine::{SineChange, SineJoint, SineJointChange, SineTask};

use super::tagged::tagged;

tagged! {
    /// One task. Where tasks overlap in time, later ones in the file win per joint.
    TaskSpec, "task" {
        /// Move joints to a posture.
        "posture" => Posture(PostureTask),
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
            TaskSpec::Posture(_) | TaskSpec::Sine(_) => None,
        }
    }
}
