//! Results of many runs as rows of text: a summary or `runs.jsonl`, read row by row. Memory holds
//! 32 bytes per row; of a Parquet file, its table.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::compare::columns::{Columns, RunDigest};
use crate::compare::csv_rows::CsvRows;
use crate::compare::json_rows::JsonRows;
use crate::compare::parquet_rows::ParquetRows;
use crate::compare::result_row::ResultRow;
use crate::compare::row_source::{ResultsErrorCause, Rows};
use crate::files::RecordError;
use crate::files::names::SUMMARIES;
use crate::results::claims::{ClaimVerdict, read_claims};
use crate::results::searches::{SearchResult, read_searches};

/// Columns that a history of results has, and a summary has not.
pub(crate) const HISTORY_COLUMNS: [&str; 3] = ["schema", "result", "recorded_unix_s"];

/// Results of runs, open for reading.
pub struct Results {
    /// The file.
    pub path: PathBuf,
    columns: Arc<Columns>,
    /// Digest of scenario and key of each row.
    runs: Vec<RunDigest>,
    rows: Box<dyn Rows>,
    /// Results of claims, where they are not in `claims.json` next to the file.
    claims: Option<Vec<ClaimVerdict>>,
}

/// Error of reading results.
#[derive(Debug, thiserror::Error)]
#[error("{}: {cause}", path.display())]
pub struct ResultsError {
    /// The file or folder.
    pub path: PathBuf,
    /// The cause.
    pub cause: ResultsErrorCause,
}

impl Results {
    /// Opens a summary (`.csv` or `.parquet`), `runs.jsonl`, or the first of these in a folder of
    /// results.
    ///
    /// # Errors
    /// No such file, another kind of file, a damaged file, or a table without runs.
    pub fn open(path: &Path) -> Result<Self, ResultsError> {
        let path = if path.is_dir() { summary_in(path)? } else { path.to_owned() };
        let fail = |cause| ResultsError { path: path.clone(), cause };
        let (columns, runs, rows) = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => CsvRows::open(&path),
            Some("parquet") => ParquetRows::open(&path),
            Some("jsonl") => JsonRows::open(&path),
            _ if !path.exists() => Err(ResultsErrorCause::Absent),
            _ => Err(ResultsErrorCause::OtherKind),
        }
        .map_err(fail)?;
        if HISTORY_COLUMNS.iter().all(|name| columns.position(name).is_some()) {
            return Err(fail(ResultsErrorCause::History));
        }
        match ["scenario", "key", "outcome"].into_iter().find(|name| columns.position(name).is_none()) {
            Some(missing) if !columns.names().is_empty() => Err(fail(ResultsErrorCause::MissingColumn(missing))),
            _ => Ok(Results { path, columns: Arc::new(columns), runs, rows, claims: None }),
        }
    }

    /// Rows of another source, with the results of their claims.
    pub(crate) fn of_rows(
        path: &Path,
        (columns, runs, rows): (Columns, Vec<RunDigest>, Box<dyn Rows>),
        claims: Vec<ClaimVerdict>,
    ) -> Self {
        Results { path: path.to_owned(), columns: Arc::new(columns), runs, rows, claims: Some(claims) }
    }

    /// Folder of the file.
    pub(crate) fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Results of the claims about these runs.
    ///
    /// # Errors
    /// `claims.json` cannot be read.
    pub(crate) fn claims(&self) -> Result<Vec<ClaimVerdict>, RecordError> {
        self.claims.clone().map_or_else(|| read_claims(self.folder()), Ok)
    }

    /// Results of the searches that chose these runs.
    ///
    /// # Errors
    /// `searches.json` cannot be read.
    pub(super) fn searches(&self) -> Result<Vec<SearchResult>, RecordError> {
        // Other sources have none.
        if self.claims.is_some() { Ok(Vec::new()) } else { read_searches(self.folder()) }
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        self.columns.names()
    }

    /// Number of runs.
    pub fn len(&self) -> usize {
        self.runs.len()
    }

    /// True if there are no runs.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Digest of scenario and key of each row.
    pub(crate) fn runs(&self) -> &[RunDigest] {
        &self.runs
    }

    /// Position of a column.
    pub(crate) fn position(&self, column: &str) -> Option<usize> {
        self.columns.position(column)
    }

    /// A row without cells, to be filled by [`Results::read`].
    pub fn blank_row(&self) -> ResultRow {
        ResultRow::blank(self.columns.clone())
    }

    /// Reads the row of a run, from 0, into a row of these results.
    ///
    /// # Errors
    /// The file cannot be read, or was changed while it was open.
    pub fn read(&mut self, position: usize, row: &mut ResultRow) -> Result<(), ResultsError> {
        let read = self.rows.read(position, &self.columns, row.cleared());
        read.map_err(|cause| ResultsError { path: self.path.clone(), cause })
    }
}

fn summary_in(folder: &Path) -> Result<PathBuf, ResultsError> {
    let found = SUMMARIES.iter().map(|name| folder.join(name)).find(|path| path.is_file());
    found.ok_or_else(|| ResultsError { path: folder.to_owned(), cause: ResultsErrorCause::EmptyFolder })
}
