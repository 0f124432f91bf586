//! Errors of reading and writing files of runs and batches.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Errors of files. Each names its file.
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
    /// The folder of results can no longer be written.
    #[error("{what}; nothing more can be written into {}: {source}", folder.display())]
    NoRoom {
        /// The file, as text.
        what: String,
        /// The folder of the results.
        folder: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A disk or quota is full.
    #[error("{what}: no more runs start, because the disk or a quota is full")]
    StorageFull {
        /// The file that could not be written and the cause, as text.
        what: String,
    },
    /// A link at the path of results.
    #[error(
        "{path}: a symbolic link to {target}: results are not written through links; remove it, or name another folder with --output"
    )]
    Link {
        /// The link.
        path: PathBuf,
        /// Its target.
        target: PathBuf,
    },
    /// A name leads out of the folder of results.
    #[error("{path} is outside {root}, the folder of results")]
    Outside {
        /// The path.
        path: PathBuf,
        /// The folder.
        root: PathBuf,
    },
    /// A list has an invalid folder name.
    #[error("{path}: \"{name}\" is not a valid folder name")]
    Name {
        /// The list.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// Another program is writing or reading these results.
    #[error("{path}: another runner is using these results: wait for it, or use another folder")]
    InUse {
        /// The locked file.
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
    /// A snapshot does not fit the model of the log.
    #[error("snapshot at {time} s has {found} {what}, the model has {expected}")]
    Shape {
        /// Time of the snapshot, s.
        time: f64,
        /// The counted quantity.
        what: &'static str,
        /// Number in the snapshot.
        found: usize,
        /// Number in the model.
        expected: usize,
    },
    /// A record is not valid JSON or lacks a field.
    #[error("{path}: {source}")]
    Json {
        /// The record.
        path: PathBuf,
        /// The cause, with line and column.
        source: serde_json::Error,
    },
    /// A file was changed after it was written.
    #[error("{path}: damaged: its content does not match its checksum")]
    Checksum {
        /// The file.
        path: PathBuf,
    },
    /// A record has an unknown format version.
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
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A second record of one run.
    #[error("{path}: the same run as {other}")]
    Duplicate {
        /// The record.
        path: PathBuf,
        /// The first one.
        other: PathBuf,
    },
    /// A picture of the report could not be drawn.
    #[error("cannot draw {what}: {reason}")]
    Plot {
        /// Its content.
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
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The report could not be written.
    #[error("{path}: cannot write the report: {source}")]
    Report {
        /// The report.
        path: PathBuf,
        /// The cause.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl RecordError {
    /// Adds a path to an input or output error.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Io { path: path.to_owned(), source }
    }

    /// True if the disk or a quota is full, so that other files cannot be written either.
    pub fn is_storage_full(&self) -> bool {
        let kind = match self {
            Self::Io { source, .. } => Some(source.kind()),
            Self::Json { source, .. } => source.io_error_kind(),
            Self::StorageFull { .. } => return true,
            _ => None,
        };
        matches!(kind, Some(ErrorKind::StorageFull | ErrorKind::QuotaExceeded))
    }
}
