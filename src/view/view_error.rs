//! Errors of showing a run.

use crate::files::RecordError;
use crate::log::LogError;
use std::path::PathBuf;

/// Why a run cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log has no poses of frames.
    #[error("{path}: nothing to draw: frames and shapes are logged if `log.topics` of the scenario contains \"scene\"")]
    NoScene {
        /// The log.
        path: PathBuf,
    },
    /// A log or a folder cannot be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The records of a folder cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
}
