//! Appends a result to a history, in a new file that replaces the old one.

use std::num::NonZeroUsize;
use std::path::Path;

use polars::prelude::{Column, DataFrame, PolarsError, PolarsResult};
use polars_io::parquet::write::ParquetWriter;
use serde::Serialize;

use crate::compare::Results;
use crate::files::{FileLock, OutputKind, RecordError, write_named};
use crate::history::result_rows::{result_digest, result_frame};
use crate::history::{Entry, History, HistoryError, HistoryErrorCause};

/// Greatest number of results that a history keeps by default.
pub const KEPT_RESULTS: NonZeroUsize = NonZeroUsize::new(500).expect("a number above 0");

/// Greatest number of rows of a history: in memory, 1 kB each.
pub const MOST_ROWS: usize = 200_000;

/// What [`append`] did.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "state", rename_all = "kebab-case")]
pub enum Appended {
    /// The result is in the history.
    New {
        /// Results in the history now.
        results: usize,
        /// Rows in the history now.
        rows: usize,
        /// Old results that were removed.
        removed: usize,
    },
    /// The history had the result already, and is unchanged.
    Known {
        /// The label that it has there.
        label: Option<String>,
        /// When the result was written.
        date: String,
    },
}

/// Appends the runs of a result to the history at `path`, which is created if it is missing. Of more
/// than `keep` results, or more than [`MOST_ROWS`] rows, the oldest results are removed. Programs that
/// append to one history take turns; a reader finds the old file or the new one.
///
/// # Errors
/// The history cannot be read, is of another kind, or cannot be written; the result cannot be read or has
/// too many rows. The history is unchanged.
pub fn append(path: &Path, results: &mut Results, label: Option<&str>, keep: usize) -> Result<Appended, AppendError> {
    History::check_name(path)?;
    let digest =
        result_digest(results).map_err(|error| HistoryError { path: error.path, cause: error.cause.into() })?;
    if results.len() > MOST_ROWS {
        let cause = HistoryErrorCause::TooLong { found: results.len(), most: MOST_ROWS };
        return Err(HistoryError { path: results.path.clone(), cause }.into());
    }
    // A link leads to one history, which has one lock.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let _lock = FileLock::wait(&target)?;
    let old = History::read_if_present(&target)?;
    if let Some(entry) = old.entry(&digest) {
        return Ok(Appended::Known { label: entry.label.clone(), date: entry.date() });
    }
    let new = result_frame(results, &digest, label)?;
    let removed = surplus(&old.entries, keep, new.height());
    let from = old.entries.get(removed).map_or(old.frame.height(), |entry| entry.rows.start);
    let table = |error: PolarsError| RecordError::Summary { path: path.to_owned(), source: error.into() };
    let kept = old.frame.slice(from as i64, old.frame.height() - from);
    let mut all = joined(&kept, &new).map_err(table)?;
    write_named(path, OutputKind::History, |out| ParquetWriter::new(out).finish(&mut all).map(|_| ()).map_err(table))?;
    Ok(Appended::New { results: old.entries.len() - removed + 1, rows: all.height(), removed })
}

/// Error of [`append`].
#[derive(Debug, thiserror::Error)]
pub enum AppendError {
    /// The history or the result cannot be read.
    #[error(transparent)]
    History(#[from] HistoryError),
    /// The history cannot be written.
    #[error(transparent)]
    Write(#[from] RecordError),
}

/// Number of old results that a new one of `rows` rows leaves no room for.
fn surplus(entries: &[Entry], keep: usize, rows: usize) -> usize {
    let mut kept = 0;
    let mut all = rows;
    for entry in entries.iter().rev() {
        all += entry.rows.len();
        if kept + 2 > keep || all > MOST_ROWS {
            break;
        }
        kept += 1;
    }
    entries.len() - kept
}

/// The rows of both. A column that one lacks has no values there.
fn joined(old: &DataFrame, new: &DataFrame) -> PolarsResult<DataFrame> {
    let in_old = |name: &str| old.columns().iter().any(|column| column.name() == name);
    let names = old.columns().iter().chain(new.columns().iter().filter(|column| !in_old(column.name())));
    let column = |known: &Column| {
        let part = |frame: &DataFrame| match frame.column(known.name()) {
            Ok(own) => own.clone(),
            Err(_) => Column::full_null(known.name().clone(), frame.height(), known.dtype()),
        };
        let (mut all, new) = (part(old), part(new));
        all.append(&new)?;
        Ok(all)
    };
    let columns = names.map(column).collect::<PolarsResult<Vec<_>>>()?;
    DataFrame::new(old.height() + new.height(), columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_results_leave_first() {
        let entry = |from: usize, to: usize| Entry {
            result: String::new(),
            recorded_unix_s: 0,
            label: None,
            program: None,
            claims: Vec::new(),
            rows: from..to,
        };
        let entries = [entry(0, 10), entry(10, 20), entry(20, 30)];
        for (keep, rows, removed) in
            [(4, 1, 0), (3, 1, 1), (1, 1, 3), (9, MOST_ROWS - 30, 0), (9, MOST_ROWS - 29, 1), (9, MOST_ROWS, 3)]
        {
            assert_eq!(surplus(&entries, keep, rows), removed, "{keep} {rows}");
        }
        assert_eq!(surplus(&[], 1, 5), 0);
    }
}
