//! What can go wrong while recording.

use std::path::{Path, PathBuf};

/// Errors of this room. Each names the file it is about.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file system refused.
    #[error("{path}: {source}")]
    Io {
        /// The file, or the folder when it could not be created.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file could not be written, and neither can any other beside it.
    #[error("{what}; nothing more can be written into {}: {source}", folder.display())]
    NoRoom {
        /// The file, in the words of what failed.
        what: String,
        /// The folder of the results.
        folder: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A link stands where results are written.
    #[error(
        "{path}: a symbolic link to {target}: nothing is written through links in a folder of results; remove it, or name with --output where results shall go"
    )]
    Link {
        /// The link.
        path: PathBuf,
        /// What it leads to.
        target: PathBuf,
    },
    /// A name leads out of the folder of results.
    #[error("{path} lies outside {root}, the folder of results")]
    Outside {
        /// What was named.
        path: PathBuf,
        /// The folder.
        root: PathBuf,
    },
    /// A list names what is no folder of results.
    #[error("{path}: \"{name}\" is no name of a folder of results")]
    Name {
        /// The list.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// Another program is writing these results.
    #[error("{path}: another runner is writing these results: wait for its end, or give this one a folder of its own")]
    InUse {
        /// The file that it has open.
        path: PathBuf,
    },
    /// The log could not be written.
    #[error("{path}: cannot write the log: {source}")]
    Log {
        /// The log.
        path: PathBuf,
        /// The cause.
        source: mcap::McapError,
    },
    /// A message could not be encoded.
    #[error("cannot encode a message for {topic}: {reason}")]
    Encode {
        /// Topic of the message.
        topic: &'static str,
        /// The cause.
        reason: String,
    },
    /// A snapshot has another shape than the model the log was opened for.
    #[error("snapshot at {time} s has {found} {what}, the model has {expected}")]
    Shape {
        /// Time of the snapshot, s.
        time: f64,
        /// What was counted.
        what: &'static str,
        /// How many the snapshot has.
        found: usize,
        /// How many it should have.
        expected: usize,
    },
    /// A record is no valid JSON or lacks a field.
    #[error("{path}: {source}")]
    Json {
        /// The record.
        path: PathBuf,
        /// The cause, with line and column.
        source: serde_json::Error,
    },
    /// A record has a format version this program does not know.
    #[error("{path}: record format {found}, this program reads {expected}")]
    Version {
        /// The record.
        path: PathBuf,
        /// Version in the file.
        found: u64,
        /// Version of this program.
        expected: u32,
    },
    /// The summary table could not be built or written.
    #[error("{path}: cannot write the summary: {source}")]
    Summary {
        /// The table.
        path: PathBuf,
        /// The cause.
        source: polars::error::PolarsError,
    },
    /// A record of a run that has been read already.
    #[error("{path}: the same run as {other}")]
    Twice {
        /// The record.
        path: PathBuf,
        /// The one read before it.
        other: PathBuf,
    },
    /// A picture of the report could not be drawn.
    #[error("cannot draw {what}: {reason}")]
    Plot {
        /// What it shows.
        what: String,
        /// The cause.
        reason: String,
    },
    /// Test results could not be written as JUnit XML.
    #[error("{path}: cannot write test results: {source}")]
    Junit {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: quick_junit::SerializeError,
    },
    /// The report could not be put together.
    #[error("{path}: cannot write the report: {source}")]
    Report {
        /// The report.
        path: PathBuf,
        /// The cause.
        source: minijinja::Error,
    },
}

impl RecordError {
    /// Gives an input or output error its path.
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Io { path: path.to_owned(), source }
    }
}
