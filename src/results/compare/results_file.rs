//! Reads results as text: from a folder, a summary or `runs.jsonl`.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use polars::prelude::{AnyValue, DataFrame, PolarsError};
use polars_io::SerReader;
use polars_io::csv::read::CsvReadOptions;
use polars_io::parquet::read::ParquetReader;
use serde_json::{Map, Value};

use crate::files::checksum::{self, Layout};
use crate::files::names::SUMMARIES;
use crate::results::compare::tolerance::is_measured;
use crate::results::is_truth;

/// Columns of text and the seed, which identify a run and its outcome.
const IDENTITY: [&str; 7] = ["scenario", "key", "outcome", "message", "method", "integrator", "seed"];

/// Rows of runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// The file.
    pub path: PathBuf,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// One per run.
    pub rows: Vec<ResultRow>,
}

/// One run: non-empty cells as text, by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResultRow(BTreeMap<String, String>);

/// Error of reading results.
#[derive(Debug, thiserror::Error)]
#[error("{}: {cause}", path.display())]
pub struct ResultsError {
    /// The file or folder.
    pub path: PathBuf,
    /// The cause.
    pub cause: ResultsErrorCause,
}

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
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A damaged table.
    #[error(transparent)]
    Table(#[from] PolarsError),
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

impl Results {
    /// Reads a summary (`.csv` or `.parquet`), `runs.jsonl`, or the first of these in a folder of
    /// results.
    ///
    /// # Errors
    /// No such file, another kind of file, or a table without runs.
    pub fn read(path: &Path) -> Result<Self, ResultsError> {
        let path = if path.is_dir() { summary_in(path)? } else { path.to_owned() };
        let fail = |cause| ResultsError { path: path.clone(), cause };
        let (columns, rows) = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => csv(&path).and_then(|frame| table(&frame)),
            Some("parquet") => parquet(&path).and_then(|frame| table(&frame)),
            Some("jsonl") => lines(&path),
            _ if !path.exists() => Err(ResultsErrorCause::Absent),
            _ => Err(ResultsErrorCause::OtherKind),
        }
        .map_err(fail)?;
        match ["scenario", "key", "outcome"].iter().find(|name| !columns.iter().any(|c| c == *name)) {
            Some(missing) if !columns.is_empty() => Err(fail(ResultsErrorCause::MissingColumn(missing))),
            _ => Ok(Results { path, columns, rows }),
        }
    }
}

impl ResultRow {
    /// A cell; empty when there is none.
    pub fn text(&self, column: &str) -> &str {
        self.0.get(column).map_or("", String::as_str)
    }

    /// The swept parameters with their values, without truths.
    pub(super) fn parameters(&self) -> impl Iterator<Item = (&str, &str)> {
        let cells = self.0.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        cells.filter(|(name, _)| {
            !IDENTITY.contains(name) && !is_measured(name) && !is_truth(name) && *name != "verdicts"
        })
    }

    /// A label of the run: scenario, parameters, and a seed other than 1.
    pub(super) fn label(&self) -> String {
        let mut parts = vec![self.text("scenario").to_owned()];
        parts.extend(self.parameters().map(|(name, value)| format!("{name}={value}")));
        let seed = self.text("seed");
        if seed != "1" && !seed.is_empty() {
            parts.push(format!("seed={seed}"));
        }
        parts.join(" ")
    }
}

fn summary_in(folder: &Path) -> Result<PathBuf, ResultsError> {
    let found = SUMMARIES.iter().map(|name| folder.join(name)).find(|path| path.is_file());
    found.ok_or_else(|| ResultsError { path: folder.to_owned(), cause: ResultsErrorCause::EmptyFolder })
}

type ReadRows = Result<(Vec<String>, Vec<ResultRow>), ResultsErrorCause>;

fn csv(path: &Path) -> Result<DataFrame, ResultsErrorCause> {
    let options = CsvReadOptions::default().with_infer_schema_length(Some(0));
    Ok(options.try_into_reader_with_file_path(Some(path.to_owned()))?.finish()?)
}

fn parquet(path: &Path) -> Result<DataFrame, ResultsErrorCause> {
    Ok(ParquetReader::new(File::open(path)?).finish()?)
}

fn table(frame: &DataFrame) -> ReadRows {
    let names: Vec<String> = frame.get_column_names().into_iter().map(ToString::to_string).collect();
    let mut rows = vec![ResultRow::default(); frame.height()];
    for (column, name) in frame.columns().iter().zip(&names) {
        for (i, row) in rows.iter_mut().enumerate() {
            let cell = match column.get(i)? {
                AnyValue::Null => continue,
                AnyValue::String(text) => text.to_owned(),
                AnyValue::StringOwned(text) => text.to_string(),
                // The shortest text that reads back to the same number.
                AnyValue::Float64(x) => format!("{x:?}"),
                other => other.to_string(),
            };
            row.0.insert(name.clone(), cell);
        }
    }
    Ok((names, rows))
}

/// Reads one object per line. A run with several lines counts once, with its last line; an
/// incomplete last line is skipped.
fn lines(path: &Path) -> ReadRows {
    let text = std::fs::read_to_string(path)?;
    let (mut columns, mut rows): (Vec<String>, Vec<ResultRow>) = (Vec::new(), Vec::new());
    let count = text.lines().count();
    for (number, line) in text.lines().enumerate() {
        let object: Map<String, Value> = match serde_json::from_str(line) {
            Ok(object) => object,
            Err(_) if number + 1 == count && !text.ends_with('\n') => continue,
            Err(error) => return Err(ResultsErrorCause::Line { line: number + 1, error }),
        };
        if !checksum::is_intact(line.as_bytes(), Layout::Line) {
            return Err(ResultsErrorCause::Damaged { line: number + 1 });
        }
        let mut row = ResultRow::default();
        for (name, value) in object.into_iter().filter(|(name, _)| name != checksum::MEMBER) {
            if !columns.contains(&name) {
                columns.push(name.clone());
            }
            match value {
                Value::Null | Value::Array(_) | Value::Object(_) => continue,
                Value::String(text) => row.0.insert(name, text),
                other => row.0.insert(name, other.to_string()),
            };
        }
        let same = |r: &ResultRow| ["scenario", "key"].iter().all(|name| r.text(name) == row.text(name));
        match rows.iter().position(same) {
            Some(earlier) => rows[earlier] = row,
            None => rows.push(row),
        }
    }
    Ok((columns, rows))
}
