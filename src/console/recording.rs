//! A finished recording: a log file and its content.

use std::path::{Path, PathBuf};

use crate::console::console_error::ConsoleError;
use crate::log::Trajectory;

/// A finished recording.
pub struct Recording {
    /// Log file.
    pub path: PathBuf,
    /// Content of the log.
    pub log: Trajectory,
}

impl Recording {
    /// Reads a log that has at least one instant.
    pub fn read(path: &Path) -> Result<Self, ConsoleError> {
        let log = Trajectory::read(path)?;
        if log.times.is_empty() {
            return Err(ConsoleError::usage(format!("{}: the log has no instants", path.display())));
        }
        Ok(Recording { path: path.to_owned(), log })
    }

    /// First and last time, s.
    pub fn span(&self) -> (f64, f64) {
        (self.log.times[0], self.log.times[self.log.times.len() - 1])
    }
}
