//! Errors of histories.

use std::path::PathBuf;

use polars::prelude::PolarsError;

use crate::compare::ResultsErrorCause;

/// Error of a history.
#[derive(Debug, thiserror::Error)]
#[error("{}: {cause}", path.display())]
pub struct HistoryError {
    /// The file.
    pub path: PathBuf,
    /// The cause.
    pub cause: HistoryErrorCause,
}

/// Why a history cannot be read or appended to.
#[derive(Debug, thiserror::Error)]
pub enum HistoryErrorCause {
    /// The path has another extension.
    #[error("the name of a history ends with .parquet")]
    Name,
    /// A Parquet file of another kind.
    #[error("not a history: it has no column `{0}`")]
    MissingColumn(&'static str),
    /// A column has values of another type.
    #[error("not a history: column `{column}` has values of type {found}, expected {expected}")]
    Type {
        /// The column.
        column: String,
        /// Type of its values.
        found: String,
        /// Expected type.
        expected: &'static str,
    },
    /// A later program wrote it.
    #[error("row {row}: the history has format version {found}, this program reads version {expected}")]
    Version {
        /// Number of the row, from 1.
        row: usize,
        /// Its version.
        found: u32,
        /// The version of this program.
        expected: u32,
    },
    /// A cell is empty or not as the program writes it.
    #[error("row {row}: column `{column}` has the value {found}, expected {expected}")]
    Cell {
        /// Number of the row, from 1.
        row: usize,
        /// The column.
        column: String,
        /// Its value.
        found: String,
        /// Description of a valid value.
        expected: &'static str,
    },
    /// More rows than a history has.
    #[error("it has {found} rows, a history has at most {most}")]
    TooLong {
        /// Number of rows.
        found: usize,
        /// Greatest number.
        most: usize,
    },
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A damaged table.
    #[error(transparent)]
    Table(#[from] PolarsError),
    /// A table that the library for tables cannot read.
    #[error("damaged: {0}")]
    DamagedTable(String),
    /// The results to append cannot be read.
    #[error(transparent)]
    Results(#[from] ResultsErrorCause),
}
