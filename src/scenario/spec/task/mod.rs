//! `[[task]]`: what the robot is told to do. One file per type.

mod posture;
mod squat;
mod walk;

pub use posture::PostureTask;
pub use squat::SquatTask;
pub use walk::WalkTask;

use super::tagged::tagged;

tagged! {
    /// One task. Where tasks overlap in time, later ones in the file win per joint.
    TaskSpec, "task" {
        /// Move joints to a posture.
        "posture" => Posture(PostureTask),
        /// Bend the legs and rise again.
        "squat" => Squat(SquatTask),
        /// Walk, or step in place.
        "walk" => Walk(WalkTask),
    }
}
