//! Keeps what the joints are asked free of self-collision, whatever the tasks want.
//!
//! Between the tasks and the drives. In every *cycle*, at a rate of their choice, it looks where the wanted motion leads,
//! and lets the joints go there only along paths that are proven to be free **and to end at rest**: whatever comes next,
//! each joint can follow its last proven path to its end. So by induction the output is free of collisions as long as the
//! posture it begins in is. The paths keep the limits of position, speed, acceleration and jerk.
//!
//! - [`path`](JointPath): motions of one joint in pieces of constant jerk.
//! - `bound`, `prover`: proof over all of a motion, not at samples.
//! - `wanted`: what the tasks want, and where it leads (the paper's extrapolation by second derivative).
//! - `candidate`: one set of paths under proof.
//! - `tick_check`: joints that are asked exactly what the tasks want, between two tests.
//! - `methods`, `around`: what to do when the way is not free, the four methods of the paper's Table I.
//! - [`Avoider`]: the state machine.
//!
//! Between two cycles a joint whose pairs are all far from touching is *free*: it is asked exactly what the tasks want, as
//! long as a stop from there stays within what the last test proves to be free ([`tick_check`]). The others follow their paths.

mod avoider;
mod candidate;
mod desired_motion;
mod detour;
mod joint_path;
mod levers;
mod limits;
mod methods;
mod prover;
mod statistics;
mod tick_check;

pub use avoider::{Avoider, JointCommands, Settings};
pub use joint_path::JointPath;
pub use levers::levers;
pub use limits::Limits;
pub use statistics::AvoidanceStatistics;
