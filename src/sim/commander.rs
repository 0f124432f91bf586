//! Who decides what the joints are asked, when it is not the tasks of the run.

use super::error::Stop;
use crate::task::{Command, Sensed};

/// Hears the sensors at each control tick and says what the joints are asked.
pub trait Commander: Send {
    /// What the joints are asked from this tick on, into `command`, and the number of the next tick at which there is something to
    /// decide; none: never.
    ///
    /// # Errors
    /// What ends the run.
    fn exchange(&mut self, sensed: &Sensed, command: &mut Command) -> Result<Option<u64>, Stop>;

    /// The run is over; `sensed` is how.
    fn finish(&mut self, sensed: &Sensed) -> Result<(), Stop>;

    /// The run has ended, in whatever way. Gives what there is to tell a person.
    fn leave(&mut self) -> Vec<String>;
}
