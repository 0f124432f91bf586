//! Connects tasks in one process with a robot in another, over UDP.
//!
//! The two exchange what a simulation exchanges inside one process: [`crate::task::Command`] and
//! [`crate::task::SensorReadings`]. The robot side ([`MotorServer`]) owns the clock; the task side
//! ([`RobotClient`]) answers each tick.
//!
//! Imports: `random`, `robot`, `dynamics`, `task`, `sim`. Used by: `live`, `batch`, `cli`.

mod channel;
mod counts;
mod impairment;
mod link_error;
mod motor_server;
mod robot_client;
pub mod wire;

pub use channel::{Address, read_key};
pub use counts::Counts;
pub use impairment::Impairment;
pub use link_error::LinkError;
pub use motor_server::{MotorServer, Pace};
pub use robot_client::{RobotClient, RobotMessage};

use std::hash::{BuildHasher, RandomState};
use std::time::Duration;

/// Silence after which the other side counts as disconnected.
pub const SILENCE: Duration = Duration::from_secs(3);

/// An unpredictable number from the system's randomness.
pub(crate) fn nonce() -> u64 {
    RandomState::new().hash_one("link").max(1)
}
