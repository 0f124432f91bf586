//! What can go wrong with an export.

use crate::files::RecordError;

/// Why there is no export.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The log holds nothing over time.
    #[error("the log holds no time series: its scenario logged neither `state` nor `contact`")]
    NoSeries,
    /// No column has this name.
    #[error("unknown column `{name}`: {help}")]
    UnknownColumn {
        /// As it was asked for.
        name: String,
        /// What may have been meant.
        help: String,
    },
    /// No instant is chosen.
    #[error("nothing to export from {from} s to {to} s: the log reaches from {first} s to {last} s")]
    NoInstants {
        /// First instant asked for, s.
        from: f64,
        /// Last one.
        to: f64,
        /// First tick of the log.
        first: f64,
        /// Last tick.
        last: f64,
    },
    /// More rows than are sensible.
    #[error("{rows:.0} rows: a rate of {rate} Hz is too high, {} rows are allowed", crate::export::instants::MOST_ROWS)]
    TooManyRows {
        /// Rows there would be.
        rows: f64,
        /// Rate asked for, Hz.
        rate: f64,
    },
    /// Text that describes no way of writing numbers.
    #[error("`{text}` is no number format: {reason}")]
    NumberFormat {
        /// As it was given.
        text: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The table could not be encoded.
    #[error("cannot write the table: {0}")]
    Encode(#[from] polars::error::PolarsError),
    /// The file could not be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}
