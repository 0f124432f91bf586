//! Error type of the console.

use std::fmt::Display;
use std::path::PathBuf;

use crate::export::ExportError;
use crate::files::RecordError;
use crate::log::LogError;
use crate::scenario::Diagnostics;
use crate::sim::RunError;

/// Error of a command, or of the session's run.
#[derive(Debug, thiserror::Error)]
pub enum ConsoleError {
    /// Invalid arguments, or a command that is impossible at present.
    #[error("{0}")]
    Usage(String),
    /// The edited scenario would be invalid.
    #[error("{0}")]
    Scenario(Diagnostics),
    /// The run has terminated early.
    #[error("the run has ended at {time} s: {error}; `undo` reverts the last change, `reset` restarts the session")]
    Terminated {
        /// Time of termination, s.
        time: f64,
        /// Cause.
        error: RunError,
    },
    /// An `expect` does not hold, or an event of `run until` did not occur.
    #[error("{0}")]
    Expectation(String),
    /// A recording cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A recording cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Unknown columns, or a table that cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// Input or output error.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
}

impl ConsoleError {
    /// A usage error with this text.
    pub(super) fn usage(text: impl Display) -> Self {
        ConsoleError::Usage(text.to_string())
    }

    /// Text for the terminal, coloured if requested.
    pub fn render(&self, colour: bool) -> String {
        match self {
            ConsoleError::Scenario(diagnostics) => diagnostics.render(colour),
            // The export error names the option of `runner export`.
            _ => format!("error: {self}").replace("`--list-columns` shows", "`columns` shows"),
        }
    }
}
