//! Errors of a batch as a whole.

use std::path::PathBuf;

use crate::files::RecordError;

/// Failure of a batch as a whole; a run's own failure is its outcome.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// The output folder cannot be used; nothing has run.
    #[error("cannot write results into {}: {source}; --output names a folder for them", folder.display())]
    Output {
        /// The folder.
        folder: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The plan drives a remote robot more than once; nothing resets it between runs.
    #[error(
        "a remote robot (`robot.backend`) makes one run, but this batch has {0}: choose one with --filter or --set, without \
         `compare`"
    )]
    RemoteRuns(usize),
    /// A record of the batch cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The threads cannot be started.
    #[error("cannot start the threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
