//! Connects tasks in one process with a robot in another, over UDP.
//!
//! The two exchange what a simulation exchanges inside one process: [`crate::task::Command`] and
//! [`crate::task::SensorReadings`]. The robot side ([`MotorServer`]) owns the clock; the task side
//! ([`RobotClient`]) answers each tick.
//!
//! Imports: `random`, `input`, `robot`, `dynamics`, `task`, `sim`. Used by: `live`, `batch`, `cli`.

mod challenge;
mod channel;
mod counts;
mod impairment;
mod key_file;
mod link_error;
mod motor_server;
mod robot_client;
pub mod wire;

pub use channel::Address;
pub use counts::Counts;
pub use impairment::Impairment;
pub use key_file::KeyFile;
pub use link_error::LinkError;
pub use motor_server::{MotorServer, Pace};
pub use robot_client::{RobotClient, RobotMessage};

use std::time::Duration;

/// Silence after which the other side counts as disconnected.
pub const SILENCE: Duration = Duration::from_secs(3);

/// Unpredictable bytes from the system.
fn random_bytes<const N: usize>() -> Result<[u8; N], LinkError> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|error| LinkError::Random(error.to_string()))?;
    Ok(bytes)
}

/// An unpredictable number, not 0.
///
/// # Errors
/// The system has no random numbers.
pub fn nonce() -> Result<u64, LinkError> {
    Ok(u64::from_le_bytes(random_bytes()?).max(1))
}
