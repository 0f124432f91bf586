//! What a file of results is for a comparison: rows that are read in any order.

use polars::prelude::PolarsError;

use crate::compare::columns::{Columns, RunDigest};
use crate::files::RecordError;
use crate::files::names::SUMMARIES;

/// Reads the rows of a file in any order.
pub(crate) trait Rows {
    /// Reads the row at a position into `cells`, one per column; empty cells are empty texts.
    fn read(&mut self, position: usize, columns: &Columns, cells: &mut [String]) -> Result<(), ResultsErrorCause>;
}

/// Columns, digests of runs, and a reader of the rows of a file.
pub(super) type Opened = Result<(Columns, Vec<RunDigest>, Box<dyn Rows>), ResultsErrorCause>;

/// Why results cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ResultsErrorCause {
    /// There is nothing at this path.
    #[error("no such file or folder")]
    Absent,
    /// The file is of another kind.
    #[error("neither a folder of results nor a .csv, .parquet or .jsonl file")]
    OtherKind,
    /// The folder has no results.
    #[error("a folder without results: none of {}", SUMMARIES.join(", "))]
    EmptyFolder,
    /// A table that is not a summary.
    #[error("not a summary of runs: it has no column `{0}`")]
    MissingColumn(&'static str),
    /// A history, which has many results.
    #[error("a history of results: give it as --baseline")]
    History,
    /// Another program writes these results, or their claims or searches cannot be read.
    #[error(transparent)]
    Folder(#[from] RecordError),
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A damaged table.
    #[error(transparent)]
    Table(#[from] PolarsError),
    /// A table that the library for tables cannot read.
    #[error("damaged: {0}")]
    DamagedTable(String),
    /// A row of a table with too few or too many cells.
    #[error("row {row}: found {found} cells, expected {expected}, as in the header")]
    Cells {
        /// Its number, from 1, without the header.
        row: usize,
        /// Number of its cells.
        found: usize,
        /// Number of columns.
        expected: usize,
    },
    /// A line that was changed after it was written.
    #[error("line {line}: damaged: its content does not match its checksum; `--resume` writes it again")]
    Damaged {
        /// Its number, from 1.
        line: usize,
    },
    /// A line that is not a JSON object.
    #[error("line {line}: {error}")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// The parser's error.
        error: serde_json::Error,
    },
}
