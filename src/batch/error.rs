//! Errors of a batch as a whole.

use std::path::PathBuf;

use crate::files::RecordError;

/// What can go wrong with a batch as a whole; a run's own troubles are its outcome.
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
    /// A robot cannot do two things at once, and stays where a run has left it.
    #[error(
        "a robot that is somewhere else (`robot.backend`) makes one run, and this asks for it {0} times: choose one with \
         --filter or --set, without `compare`"
    )]
    Robots(usize),
    /// A record of the batch cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The threads cannot be started.
    #[error("cannot start the threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
