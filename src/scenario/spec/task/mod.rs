//! `[[task]]`: what the robot is told to do. One file per type.

mod posture;

pub use posture::PostureTask;

use super::tagged::tagged;

tagged! {
    /// One task. Where tasks overlap in time, later ones in the file win per joint.
    TaskSpec, "task" {
        /// Move joints to a posture.
        "posture" => Posture(PostureTask),
    }
}

impl TaskSpec {
    /// The file that the key `file` names, if the type has that key.
    pub fn file(&self) -> Option<&str> {
        match self {
            TaskSpec::Posture(_) => None,
        }
    }
}
