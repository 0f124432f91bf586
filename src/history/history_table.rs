//! A history in memory.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Cursor, ErrorKind};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

use polars::prelude::{DataFrame, DataType, Float64Chunked, PolarsError, StringChunked};
use polars_io::SerReader;
use polars_io::parquet::read::{ParallelStrategy, ParquetReader};

use crate::compare::{HISTORY_COLUMNS, RunDigest, identity_of};
use crate::files::catch_panic;
use crate::history::append::MOST_ROWS;
use crate::history::columns::{CLAIMS, HISTORY_SCHEMA, IDENTITY, LABEL, PARAMETERS, PROGRAM, RECORDED};
use crate::history::columns::{RESULT, SCHEMA, TEXTS};
use crate::history::{HistoryError, HistoryErrorCause};
use crate::input;
use crate::results::claims::ClaimVerdict;
use crate::text::utc_date::utc;

/// Results that were appended, the oldest first.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// The file.
    pub path: PathBuf,
    /// Its results.
    pub entries: Vec<Entry>,
    /// The whole table.
    pub(super) frame: DataFrame,
    /// The runs, by their rows.
    pub(super) runs: Vec<HistoryRun>,
    /// Metrics by name, with a value or none per row.
    pub(super) metrics: Vec<(String, Float64Chunked)>,
}

/// A result of a history.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its digest.
    pub result: String,
    /// When it was written, s since 1970.
    pub recorded_unix_s: i64,
    /// Its label.
    pub label: Option<String>,
    /// Program and version.
    pub program: Option<String>,
    /// Results of its claims.
    pub claims: Vec<ClaimVerdict>,
    /// Its rows.
    pub(super) rows: Range<usize>,
}

/// A run of a result.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HistoryRun {
    /// Texts of [`IDENTITY`].
    pub own: [String; 6],
    /// Swept parameters by name.
    pub parameters: BTreeMap<String, String>,
    /// Identity of the run without its key, and its number among equal ones of the result.
    pub identity: (RunDigest, usize),
}

impl Entry {
    /// Number of its runs.
    pub fn runs(&self) -> usize {
        self.rows.len()
    }

    /// Its date, `2026-11-21 19:05 UTC`.
    pub fn date(&self) -> String {
        let since = Duration::from_secs(self.recorded_unix_s.max(0).unsigned_abs());
        UNIX_EPOCH.checked_add(since).and_then(utc).unwrap_or_default()
    }

    /// Its label, else its date.
    pub fn title(&self) -> String {
        self.label.clone().unwrap_or_else(|| self.date())
    }
}

impl History {
    /// A history without results, to be appended to.
    pub fn empty(path: &Path) -> Self {
        History { path: path.to_owned(), ..History::default() }
    }

    /// Checks that the name of a history ends with `.parquet`.
    pub(super) fn check_name(path: &Path) -> Result<(), HistoryError> {
        match path.extension() {
            Some(extension) if extension == "parquet" => Ok(()),
            _ => Err(HistoryError { path: path.to_owned(), cause: HistoryErrorCause::Name }),
        }
    }

    /// True if the file is a Parquet file with the columns of a history.
    pub fn is_history(path: &Path) -> bool {
        let names = || {
            let schema = ParquetReader::new(File::open(path).ok()?).schema().ok()?;
            Some(HISTORY_COLUMNS.iter().all(|name| schema.iter_names().any(|own| own == name)))
        };
        path.extension().is_some_and(|e| e == "parquet") && catch_panic(names).ok().flatten().unwrap_or(false)
    }

    /// Reads a history.
    ///
    /// # Errors
    /// The file cannot be read, is of another kind or version, is damaged, or has too many rows.
    pub fn read(path: &Path) -> Result<Self, HistoryError> {
        // The library panics at some damaged files.
        let read = catch_panic(|| Self::of_frame(path, read_frame(path)?));
        let read = read.unwrap_or_else(|panic| Err(HistoryErrorCause::DamagedTable(panic)));
        read.map_err(|cause| HistoryError { path: path.to_owned(), cause })
    }

    /// Reads a history; one without results if there is no such file.
    pub(super) fn read_if_present(path: &Path) -> Result<Self, HistoryError> {
        match Self::read(path) {
            Err(HistoryError { cause: HistoryErrorCause::Io(error), .. }) if error.kind() == ErrorKind::NotFound => {
                Ok(Self::empty(path))
            }
            read => read,
        }
    }

    fn of_frame(path: &Path, frame: DataFrame) -> Result<Self, HistoryErrorCause> {
        check_types(&frame)?;
        let rows = frame.height();
        let schema = frame.column(SCHEMA)?.u32()?.clone();
        for row in 0..rows {
            match schema.get(row) {
                Some(found) if found <= HISTORY_SCHEMA => {}
                found => {
                    let found = found.unwrap_or(0);
                    return Err(HistoryErrorCause::Version { row: row + 1, found, expected: HISTORY_SCHEMA });
                }
            }
        }
        let mut history = History { path: path.to_owned(), ..History::default() };
        history.read_runs(&frame)?;
        history.read_entries(&frame)?;
        let is_metric = |name: &str| !TEXTS.contains(&name) && ![SCHEMA, RECORDED].contains(&name);
        let metrics = frame.columns().iter().filter(|c| is_metric(c.name()) && c.dtype() == &DataType::Float64);
        let metrics = metrics.map(|column| Ok((column.name().to_string(), column.f64()?.clone())));
        history.metrics = metrics.collect::<Result<_, PolarsError>>()?;
        history.frame = frame;
        Ok(history)
    }

    fn read_runs(&mut self, frame: &DataFrame) -> Result<(), HistoryErrorCause> {
        let identity = IDENTITY.map(|name| text_column(frame, name));
        let parameters = text_column(frame, PARAMETERS)?;
        for row in 0..frame.height() {
            let mut own: [String; 6] = Default::default();
            for (own, column) in own.iter_mut().zip(&identity) {
                let column = column.as_ref().map_err(|error| PolarsError::ComputeError(error.to_string().into()))?;
                *own = column.get(row).unwrap_or("").to_owned();
            }
            let text = parameters.get(row).unwrap_or("{}");
            let parameters: BTreeMap<String, String> = serde_json::from_str(text)
                .map_err(|_| cell(row, PARAMETERS, text, "a JSON object of swept parameters as texts"))?;
            let named = parameters.iter().map(|(name, value)| (name.as_str(), value.as_str()));
            let [scenario, _, _, method, integrator, seed] = &own;
            let identity = (identity_of([scenario, method, integrator, seed], named), 0);
            self.runs.push(HistoryRun { own, parameters, identity });
        }
        Ok(())
    }

    /// Groups the rows by their results, and numbers equal runs of a result.
    fn read_entries(&mut self, frame: &DataFrame) -> Result<(), HistoryErrorCause> {
        let result = text_column(frame, RESULT)?;
        let (label, program, claims) =
            (text_column(frame, LABEL)?, text_column(frame, PROGRAM)?, text_column(frame, CLAIMS)?);
        let recorded = frame.column(RECORDED)?.i64()?.clone();
        let mut equal: BTreeMap<RunDigest, usize> = BTreeMap::new();
        for row in 0..frame.height() {
            let own = result.get(row).ok_or_else(|| cell(row, RESULT, "null", "the digest of a result"))?;
            if self.entries.last().is_none_or(|entry| entry.result != own) {
                equal.clear();
                self.entries.push(Entry {
                    result: own.to_owned(),
                    recorded_unix_s: recorded.get(row).unwrap_or(0),
                    label: label.get(row).map(str::to_owned),
                    program: program.get(row).map(str::to_owned),
                    claims: Vec::new(),
                    rows: row..row,
                });
            }
            let count = equal.entry(self.runs[row].identity.0).or_default();
            self.runs[row].identity.1 = *count;
            *count += 1;
            let Some(entry) = self.entries.last_mut() else { continue };
            entry.rows.end = row + 1;
            if let Some(text) = claims.get(row) {
                let claims: Vec<ClaimVerdict> =
                    serde_json::from_str(text).map_err(|_| cell(row, CLAIMS, text, "results of claims as JSON"))?;
                entry.claims.extend(claims);
            }
        }
        Ok(())
    }

    /// The entry with a digest.
    pub fn entry(&self, result: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.result == result)
    }
}

fn cell(row: usize, column: &str, found: &str, expected: &'static str) -> HistoryErrorCause {
    HistoryErrorCause::Cell { row: row + 1, column: column.to_owned(), found: format!("`{found}`"), expected }
}

fn text_column(frame: &DataFrame, name: &str) -> Result<StringChunked, PolarsError> {
    Ok(frame.column(name)?.str()?.clone())
}

/// Checks that all columns that a history needs are there and have their types.
fn check_types(frame: &DataFrame) -> Result<(), HistoryErrorCause> {
    let needed = [(SCHEMA, DataType::UInt32, "whole numbers"), (RECORDED, DataType::Int64, "whole numbers")];
    let needed = needed.into_iter().chain(TEXTS.map(|name| (name, DataType::String, "text")));
    for (name, dtype, expected) in needed {
        let column = frame.column(name).map_err(|_| HistoryErrorCause::MissingColumn(name))?;
        if column.dtype() != &dtype {
            let found = column.dtype().to_string();
            return Err(HistoryErrorCause::Type { column: name.to_owned(), found, expected });
        }
    }
    Ok(())
}

fn read_frame(path: &Path) -> Result<DataFrame, HistoryErrorCause> {
    // In memory: other programs may replace the file meanwhile, or shorten it, which would end a program that has
    // mapped it.
    let bytes = input::read(path, u64::MAX)?;
    // On this thread, where a panic is caught.
    let mut reader = ParquetReader::new(Cursor::new(bytes)).read_parallel(ParallelStrategy::None).set_rechunk(true);
    let height = reader.num_rows()?;
    if height > MOST_ROWS {
        return Err(HistoryErrorCause::TooLong { found: height, most: MOST_ROWS });
    }
    let frame = reader.finish()?;
    if frame.height() != height {
        return Err(HistoryErrorCause::DamagedTable(format!("it has fewer rows than it states, {height}")));
    }
    Ok(frame)
}
