//! Source of joint commands when tasks run in another process.

use super::run_error::RunError;
use crate::task::{Command, SensorReadings};

/// Receives the sensor readings at each control tick and returns joint commands.
pub trait CommandSource: Send {
    /// Writes to `command` the joint commands that hold from this tick on. Returns the number of
    /// the next tick with a new command; none if there is no further one.
    ///
    /// # Errors
    /// An error that ends the run.
    fn exchange(&mut self, sensed: &SensorReadings, command: &mut Command) -> Result<Option<u64>, RunError>;

    /// Called when the run has reached its end, with the readings there.
    ///
    /// # Errors
    /// An error of the connection.
    fn finish(&mut self, sensed: &SensorReadings) -> Result<(), RunError>;

    /// Called when the run has ended, with or without error. Returns notes for the user.
    fn leave(&mut self) -> Vec<String>;
}
