//! Source of joint commands when tasks run in another process.

use super::run_error::RunError;
use crate::task::{Command, Sensed};

/// Receives the sensor readings at each control tick and returns joint commands.
pub trait CommandSource: Send {
    /// Writes the joint commands from this tick on to `command`. Returns the number of the next tick with a new
    /// command; none if there is no further one.
    ///
    /// # Errors
    /// An error that ends the run.
    fn exchange(&mut self, sensed: &Sensed, command: &mut Command) -> Result<Option<u64>, RunError>;

    /// The run has reached its end with the readings `sensed`.
    ///
    /// # Errors
    /// An error of the connection.
    fn finish(&mut self, sensed: &Sensed) -> Result<(), RunError>;

    /// The run has ended, with or without error. Returns notes for the user.
    fn leave(&mut self) -> Vec<String>;
}
