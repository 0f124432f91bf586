//! Self-collision avoidance: keeps joint commands free of self-collision.
//!
//! Runs between the tasks and the drives. Every *cycle*, at its own rate, extrapolates the desired
//! motion and lets the joints follow it only along paths that are proven free of collision **and
//! end at rest**. Each joint can therefore always follow its last proven path to its end: by
//! induction the output is collision-free if the initial posture is. The paths keep the limits of
//! position, speed, acceleration and jerk.
//!
//! Between two cycles a joint whose pairs are all far from touching is *free*: it follows the
//! desired motion exactly while a stop from it stays within the motion that the last test proves
//! free.
//!
//! | file, lowest first | content |
//! |---|---|
//! | `limits` | motion limits of a joint |
//! | [`joint_path`](JointPath) | motions of one joint in pieces of constant jerk |
//! | `levers`, `prover` | proof over a whole motion, not at samples |
//! | `desired_motion` | the motion that the tasks command, and the paper's extrapolation by second derivatives |
//! | `candidate` | one set of paths to be proven |
//! | `tick_check` | free joints between cycles |
//! | `planner`, `detour`, `methods` | the four methods of the paper's Table I |
//! | [`avoider`](Avoider) | the interface |

mod avoider;
mod candidate;
mod desired_motion;
mod detour;
mod joint_path;
mod levers;
mod limits;
mod methods;
mod planner;
mod prover;
mod statistics;
mod tick_check;

pub use avoider::{Avoider, JointCommands};
pub use joint_path::JointPath;
pub use levers::levers;
pub use limits::Limits;
pub use planner::Settings;
pub use statistics::AvoidanceStatistics;
