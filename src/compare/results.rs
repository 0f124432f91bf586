//! Results of many runs as rows of text: a summary or `runs.jsonl`, read row by row. Memory holds
//! 32 bytes per row; of a Parquet file, its table.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use crate::compare::columns::{Columns, RunDigest};
use crate::compare::csv_rows::CsvRows;
use crate::compare::json_rows::JsonRows;
use crate::compare::parquet_rows::ParquetRows;
use crate::compare::result_row::ResultRow;
use crate::compare::row_source::{ResultsErrorCause, Rows};
use crate::files::RecordError;
use crate::files::names::{RUNS_LOG, SUMMARIES};
use crate::results::ResultsLock;
use crate::results::claims::{ChangeClaim, ClaimVerdict, read_claims};
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
    beside: Beside,
    /// Keeps batches from adding lines.
    _lock: Option<ResultsLock>,
}

/// What belongs to the rows.
#[derive(Default)]
struct Beside {
    /// When the rows were written, if that is known.
    modified: Option<SystemTime>,
    /// Results of their claims.
    claims: Vec<ClaimVerdict>,
    /// Claims about changes.
    changes: Vec<ChangeClaim>,
    /// Results of the searches that chose the runs.
    searches: Vec<SearchResult>,
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
    /// No such file, another kind of file, a damaged file, a table without runs, or a folder where another
    /// program is writing.
    pub fn open(path: &Path) -> Result<Self, ResultsError> {
        let is_folder = path.is_dir();
        let is_summary =
            path.file_name().is_some_and(|name| SUMMARIES.iter().any(|own| name == *own && *own != RUNS_LOG));
        let folder = if is_folder { path } else { path.parent().unwrap_or(Path::new("")) };
        let refused = |path: &Path, cause: RecordError| ResultsError { path: path.to_owned(), cause: cause.into() };
        // A batch has written none, or some, of the files that belong together.
        let lock = (is_folder || is_summary).then(|| ResultsLock::shared(folder)).transpose();
        let lock = lock.map_err(|cause| refused(path, cause))?;
        let path = if is_folder { summary_in(path)? } else { path.to_owned() };
        let fail = |cause| ResultsError { path: path.clone(), cause };
        let open = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => CsvRows::open,
            Some("parquet") => ParquetRows::open,
            Some("jsonl") => JsonRows::open,
            _ if !path.exists() => return Err(fail(ResultsErrorCause::Absent)),
            _ => return Err(fail(ResultsErrorCause::OtherKind)),
        };
        let file = File::open(&path).map_err(|error| fail(error.into()))?;
        let beside = Beside::read(folder, &file).map_err(|cause| refused(&path, cause))?;
        // Other files are replaced as a whole, and stay as they are while they are open.
        let lock = lock.filter(|_| path.ends_with(RUNS_LOG));
        let (columns, runs, rows) = open(file).map_err(fail)?;
        if HISTORY_COLUMNS.iter().all(|name| columns.position(name).is_some()) {
            return Err(fail(ResultsErrorCause::History));
        }
        match ["scenario", "key", "outcome"].into_iter().find(|name| columns.position(name).is_none()) {
            Some(missing) if !columns.names().is_empty() => Err(fail(ResultsErrorCause::MissingColumn(missing))),
            _ => Ok(Results { path, columns: Arc::new(columns), runs, rows, beside, _lock: lock }),
        }
    }

    /// Rows of another source, with the results of their claims.
    pub(crate) fn of_rows(
        path: &Path,
        (columns, runs, rows): (Columns, Vec<RunDigest>, Box<dyn Rows>),
        claims: Vec<ClaimVerdict>,
    ) -> Self {
        let beside = Beside { claims, ..Beside::default() };
        Results { path: path.to_owned(), columns: Arc::new(columns), runs, rows, beside, _lock: None }
    }

    /// Folder of the file.
    pub(crate) fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// When the rows were written, if that is known.
    pub(crate) fn modified(&self) -> Option<SystemTime> {
        self.beside.modified
    }

    /// Results of the claims about these runs.
    pub(crate) fn claims(&self) -> &[ClaimVerdict] {
        &self.beside.claims
    }

    /// Claims about changes of these runs from a baseline.
    pub(super) fn changes(&self) -> &[ChangeClaim] {
        &self.beside.changes
    }

    /// Results of the searches that chose these runs.
    pub(super) fn searches(&self) -> &[SearchResult] {
        &self.beside.searches
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

impl Beside {
    fn read(folder: &Path, rows: &File) -> Result<Self, RecordError> {
        let modified = rows.metadata().and_then(|about| about.modified()).ok();
        let (claims, changes) = read_claims(folder)?;
        Ok(Beside { modified, claims, changes, searches: read_searches(folder)? })
    }
}

fn summary_in(folder: &Path) -> Result<PathBuf, ResultsError> {
    let found = SUMMARIES.iter().map(|name| folder.join(name)).find(|path| path.is_file());
    found.ok_or_else(|| ResultsError { path: folder.to_owned(), cause: ResultsErrorCause::EmptyFolder })
}
