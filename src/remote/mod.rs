//! One task, here or there: tasks that run in one process and a robot in another, over UDP.
//!
//! What passes between them is what passes inside a simulation: [`crate::task::Command`] and [`crate::task::Sensed`].
//! The robot's side ([`MotorServer`]) has the clock; the tasks' side ([`Remote`]) answers each of its ticks.

mod channel;
mod counts;
mod error;
mod impair;
mod motor_server;
mod task_side;
pub mod wire;

pub use channel::{Address, read_key};
pub use counts::Counts;
pub use error::LinkError;
pub use impair::Impairment;
pub use motor_server::{MotorServer, Pace};
pub use task_side::{Heard, Remote};

use std::hash::{BuildHasher, RandomState};
use std::time::Duration;

/// Silence after which the other side counts as gone.
pub const SILENCE: Duration = Duration::from_secs(3);

/// A number that nobody foresees, from the system's randomness.
pub(crate) fn nonce() -> u64 {
    RandomState::new().hash_one("link").max(1)
}
