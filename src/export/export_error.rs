//! Errors of an export.

use crate::export::selection::MAX_ROWS;
use crate::files::RecordError;
use std::path::PathBuf;

/// Why a log is not exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The log has no time series.
    #[error("the log holds no time series: its scenario logged neither `state` nor `contact`")]
    NoSeries,
    /// No column has this name.
    #[error("unknown column `{name}`: {help}")]
    UnknownColumn {
        /// The requested name.
        name: String,
        /// A similar name, or where to find the names.
        help: String,
    },
    /// The log has nothing for a bag.
    #[error("the log has no topics for a bag: its scenario logged none of `state`, `contact` and `scene`")]
    NoTopics,
    /// The selection contains no instant.
    #[error("nothing to export from {from} s to {to} s: the log reaches from {first} s to {last} s")]
    NoInstants {
        /// First requested instant, s.
        from: f64,
        /// Last requested instant, s.
        to: f64,
        /// First tick of the log, s.
        first: f64,
        /// Last tick, s.
        last: f64,
    },
    /// The table would be too long.
    #[error("{rows:.0} rows: a rate of {rate} Hz is too high, {MAX_ROWS} rows are allowed")]
    TooManyRows {
        /// Rows of the table.
        rows: f64,
        /// Requested rate, Hz.
        rate: f64,
    },
    /// The table could not be encoded.
    #[error("cannot write the table: {0}")]
    Encode(#[from] polars::error::PolarsError),
    /// A message of a bag could not be encoded.
    #[error("cannot encode a message for {topic}: {reason}")]
    Message {
        /// Topic of the message.
        topic: String,
        /// The cause.
        reason: String,
    },
    /// The file of a bag could not be written.
    #[error("{path}: cannot write the bag: {source}")]
    Bag {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: mcap::McapError,
    },
    /// The file could not be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}
