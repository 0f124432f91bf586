//! The interface of a topic that is written at every tick.

use crate::files::RecordError;
use crate::log::write::log_output::LogOutput;
use crate::sim::Snapshot;

/// A topic with one message per tick. Implementations encode straight into the output's buffer, so that
/// writing does not allocate.
pub(super) trait Topic: Send {
    /// Writes the message of a snapshot; `time` in nanoseconds.
    fn record(&mut self, time: u64, snapshot: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError>;
}
