//! Results read back as text: from a folder, a summary or `runs.jsonl`.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use polars::prelude::{AnyValue, DataFrame};
use polars_io::SerReader;
use polars_io::csv::read::CsvReadOptions;
use polars_io::parquet::read::ParquetReader;
use serde_json::{Map, Value};

use crate::results::changes::columns::is_measured;
use crate::results::is_truth;

/// Columns of words and the seed: they say which run it is and how it ended.
const IDENTITY: [&str; 7] = ["scenario", "key", "outcome", "message", "method", "integrator", "seed"];

/// Rows of runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// The file they are from.
    pub path: PathBuf,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// One per run.
    pub rows: Vec<Row>,
}

/// One run; cells as text by their columns, empty ones left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row(BTreeMap<String, String>);

/// Why results cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct ResultsError {
    /// The file or folder.
    pub path: PathBuf,
    /// In words.
    pub reason: String,
}

impl Results {
    /// Reads a summary (`.csv` or `.parquet`), `runs.jsonl`, or the first of these in a folder of results.
    ///
    /// # Errors
    /// No such file, none of these, or not made of runs.
    pub fn read(path: &Path) -> Result<Self, ResultsError> {
        let path = if path.is_dir() { inside(path)? } else { path.to_owned() };
        let fail = |reason: String| ResultsError { path: path.clone(), reason };
        let (columns, rows) = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => table(csv(&path)),
            Some("parquet") => table(parquet(&path)),
            Some("jsonl") => lines(&path),
            _ if !path.exists() => Err("no such file or folder".into()),
            _ => Err("neither a folder of results nor a .csv, .parquet or .jsonl file".into()),
        }
        .map_err(fail)?;
        match ["scenario", "key", "outcome"].iter().find(|name| !columns.iter().any(|c| c == *name)) {
            Some(missing) if !columns.is_empty() => {
                Err(fail(format!("no summary of runs: it has no column `{missing}`")))
            }
            _ => Ok(Results { path, columns, rows }),
        }
    }
}

impl Row {
    /// A cell; empty when there is none.
    pub fn text(&self, column: &str) -> &str {
        self.0.get(column).map_or("", String::as_str)
    }

    /// The swept parameters with their values, truths that are swept along left out.
    pub(super) fn parameters(&self) -> impl Iterator<Item = (&str, &str)> {
        let cells = self.0.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        cells.filter(|(name, _)| {
            !IDENTITY.contains(name) && !is_measured(name) && !is_truth(name) && *name != "verdicts"
        })
    }

    /// The run in words: scenario, parameters, and what else tells it from others.
    pub(super) fn label(&self) -> String {
        let mut words = vec![self.text("scenario").to_owned()];
        words.extend(self.parameters().map(|(name, value)| format!("{name}={value}")));
        let seed = self.text("seed");
        if seed != "1" && !seed.is_empty() {
            words.push(format!("seed={seed}"));
        }
        words.join(" ")
    }
}

fn inside(folder: &Path) -> Result<PathBuf, ResultsError> {
    let names = ["summary.csv", "summary.parquet", "runs.jsonl"];
    let found = names.iter().map(|name| folder.join(name)).find(|path| path.is_file());
    found.ok_or_else(|| ResultsError {
        path: folder.to_owned(),
        reason: format!("a folder without results: none of {}", names.join(", ")),
    })
}

type Read = Result<(Vec<String>, Vec<Row>), String>;

fn csv(path: &Path) -> Result<DataFrame, String> {
    let options = CsvReadOptions::default().with_infer_schema_length(Some(0));
    let reader = options.try_into_reader_with_file_path(Some(path.to_owned())).map_err(|e| e.to_string())?;
    reader.finish().map_err(|e| e.to_string())
}

fn parquet(path: &Path) -> Result<DataFrame, String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    ParquetReader::new(file).finish().map_err(|e| e.to_string())
}

fn table(frame: Result<DataFrame, String>) -> Read {
    let frame = frame?;
    let names: Vec<String> = frame.get_column_names().into_iter().map(ToString::to_string).collect();
    let mut rows = vec![Row::default(); frame.height()];
    for (column, name) in frame.columns().iter().zip(&names) {
        for (i, row) in rows.iter_mut().enumerate() {
            let cell = match column.get(i).map_err(|e| e.to_string())? {
                AnyValue::Null => continue,
                AnyValue::String(text) => text.to_owned(),
                AnyValue::StringOwned(text) => text.to_string(),
                // The shortest text that reads back to the same.
                AnyValue::Float64(x) => format!("{x:?}"),
                other => other.to_string(),
            };
            row.0.insert(name.clone(), cell);
        }
    }
    Ok((names, rows))
}

/// One object per line; a file that several batches appended to counts each run once, as it ended last. The last line of a
/// batch that was killed may be torn.
fn lines(path: &Path) -> Read {
    let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
    let (mut columns, mut rows): (Vec<String>, Vec<Row>) = (Vec::new(), Vec::new());
    let count = text.lines().count();
    for (number, line) in text.lines().enumerate() {
        let object: Map<String, Value> = match serde_json::from_str(line) {
            Ok(object) => object,
            Err(_) if number + 1 == count && !text.ends_with('\n') => continue,
            Err(error) => return Err(format!("line {}: {error}", number + 1)),
        };
        let mut row = Row::default();
        for (name, value) in object {
            if !columns.contains(&name) {
                columns.push(name.clone());
            }
            match value {
                Value::Null | Value::Array(_) | Value::Object(_) => continue,
                Value::String(text) => row.0.insert(name, text),
                other => row.0.insert(name, other.to_string()),
            };
        }
        let same = |r: &Row| ["scenario", "key"].iter().all(|name| r.text(name) == row.text(name));
        match rows.iter().position(same) {
            Some(earlier) => rows[earlier] = row,
            None => rows.push(row),
        }
    }
    Ok((columns, rows))
}
