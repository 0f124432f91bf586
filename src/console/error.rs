//! Why a line at the console does nothing.

use std::path::PathBuf;

use crate::export::ExportError;
use crate::files::RecordError;
use crate::log::LogError;
use crate::scenario::Diagnostics;
use crate::sim::RunError;

/// Why a line does nothing, or ends the session's run.
#[derive(Debug, thiserror::Error)]
pub enum ConsoleError {
    /// The line is not what the command wants.
    #[error("{0}")]
    Usage(String),
    /// The scenario would not be sound.
    #[error("{0}")]
    Scenario(Diagnostics),
    /// The run has ended and goes on no more.
    #[error("the run has ended at {time} s: {stop}; `undo` takes the last change back, `reset` begins anew")]
    Over {
        /// When, s.
        time: f64,
        /// Why.
        stop: RunError,
    },
    /// A `expect` that does not hold.
    #[error("{0}")]
    Expectation(String),
    /// A recording cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A recording cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Columns that are not there, or a file that cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The file system refuses.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl ConsoleError {
    /// Wrong words, with what is wanted.
    pub(super) fn usage(words: impl Into<String>) -> Self {
        ConsoleError::Usage(words.into())
    }

    /// For a person, with colours if they are wanted.
    pub fn render(&self, colour: bool) -> String {
        match self {
            ConsoleError::Scenario(diagnostics) => diagnostics.render(colour),
            // On a command line it is an option.
            _ => format!("error: {self}").replace("`--list-columns` shows", "`columns` shows"),
        }
    }
}
