//! Writes `summary.csv` and `summary.parquet`, one row per run, in parts: a million rows need no
//! more memory than thousands.

use crate::files::names;
use crate::files::{RecordError, atomic};
use crate::metrics::{COLUMNS, Measure};
use crate::results::summary::summary_row::{TEXT_COLUMNS, truth_columns, truth_error};
use crate::results::{ParamValue, SummaryRow};
use polars::prelude::{Column, DataFrame, NamedFrom, PolarsResult, Series};
use polars_io::SerWriter;
use polars_io::csv::write::CsvWriter;
use polars_io::parquet::write::ParquetWriter;
use std::path::{Path, PathBuf};

/// Rows in memory at a time.
const PART: usize = 8192;

/// Paths of the summary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SummaryFiles {
    /// `summary.csv`.
    pub csv: PathBuf,
    /// `summary.parquet`.
    pub parquet: PathBuf,
}

/// Rows that can be visited more than once, in the same order each time; they need not be in
/// memory.
pub trait Rows {
    /// Calls `visit` with each row.
    ///
    /// # Errors
    /// A row cannot be read, or `visit` fails.
    fn for_each(&self, visit: &mut dyn FnMut(&SummaryRow) -> Result<(), RecordError>) -> Result<(), RecordError>;
}

impl Rows for &[SummaryRow] {
    fn for_each(&self, visit: &mut dyn FnMut(&SummaryRow) -> Result<(), RecordError>) -> Result<(), RecordError> {
        self.iter().try_for_each(visit)
    }
}

/// Writes `summary.csv` and `summary.parquet` into `folder`, one row per run in the given order.
///
/// # Errors
/// The folder or a file cannot be written, or a swept parameter has the name of a column.
pub fn write_summary(folder: &Path, rows: &[SummaryRow]) -> Result<SummaryFiles, RecordError> {
    write_summary_of(folder, &rows)
}

/// Like [`write_summary`], for rows that are read one by one, in two passes: first for the columns.
///
/// # Errors
/// See [`write_summary`]; and a row cannot be read.
pub fn write_summary_of(folder: &Path, rows: &dyn Rows) -> Result<SummaryFiles, RecordError> {
    let files = SummaryFiles { csv: folder.join(names::SUMMARY_CSV), parquet: folder.join(names::SUMMARY_PARQUET) };
    let failure = |path: &Path| {
        let path = path.to_owned();
        move |source| RecordError::Summary { path, source }
    };
    let mut layout = Layout::default();
    rows.for_each(&mut |row| {
        layout.add(row);
        Ok(())
    })?;
    let empty = layout.frame(&[]).map_err(failure(&files.csv))?;
    let schema = empty.schema();
    atomic::write(&files.csv, |csv| {
        atomic::write(&files.parquet, |parquet| {
            let mut csv = CsvWriter::new(csv).batched(schema).map_err(failure(&files.csv))?;
            let mut parquet = ParquetWriter::new(parquet).batched(schema).map_err(failure(&files.parquet))?;
            let mut write = |part: &mut Vec<SummaryRow>| {
                let frame = layout.frame(part).map_err(failure(&files.csv))?;
                part.clear();
                csv.write_batch(&frame).map_err(failure(&files.csv))?;
                parquet.write_batch(&frame).map_err(failure(&files.parquet))
            };
            let mut part = Vec::new();
            rows.for_each(&mut |row| {
                part.push(row.clone());
                if part.len() == PART { write(&mut part) } else { Ok(()) }
            })?;
            if !part.is_empty() {
                write(&mut part)?;
            }
            csv.finish().map_err(failure(&files.csv))?;
            parquet.finish().map(|_| ()).map_err(failure(&files.parquet))
        })
    })?;
    Ok(files)
}

/// The columns that depend on the rows. They are empty where a row lacks a value.
#[derive(Default)]
struct Layout {
    /// Swept parameters of all rows, in the order of first appearance.
    parameters: Vec<(String, ParameterType)>,
    /// Columns of distances from truths, in the order of first appearance.
    truths: Vec<String>,
}

/// Type of a parameter's column; each type can represent the values of those before it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum ParameterType {
    Whole,
    Real,
    Text,
}

impl Layout {
    fn add(&mut self, row: &SummaryRow) {
        for (name, value) in &row.parameters {
            let kind = match value {
                ParamValue::Integer(_) => ParameterType::Whole,
                ParamValue::Number(_) => ParameterType::Real,
                ParamValue::Flag(_) | ParamValue::Text(_) => ParameterType::Text,
            };
            match self.parameters.iter_mut().find(|(known, _)| known == name) {
                Some((_, known)) => *known = kind.max(*known),
                None => self.parameters.push((name.clone(), kind)),
            }
        }
        for name in truth_columns(std::slice::from_ref(row)) {
            if !self.truths.contains(&name) {
                self.truths.push(name);
            }
        }
    }

    /// A part of the summary as a table: identity and `seed`; swept parameters; metrics; distances
    /// from known truths.
    fn frame(&self, rows: &[SummaryRow]) -> PolarsResult<DataFrame> {
        let texts = TEXT_COLUMNS.iter().map(|c| text_series(c.name, rows.iter().map(|r| Some((c.get)(r).to_owned()))));
        let seed = Series::new("seed".into(), rows.iter().map(|r| r.seed).collect::<Vec<_>>());
        let parameters = self.parameters.iter().map(|(name, kind)| parameter_series(name, *kind, rows));
        let metrics = COLUMNS.iter().map(|column| metric_series(column, rows));
        let truths = self.truths.iter().map(|name| {
            let errors: Vec<Option<f64>> = rows.iter().map(|row| truth_error(row, name)).collect();
            Series::new(name.as_str().into(), errors)
        });
        let all = texts.chain([seed]).chain(parameters).chain(metrics).chain(truths).map(Column::from).collect();
        DataFrame::new(rows.len(), all)
    }
}

/// Names of all swept parameters, in the order of first appearance.
pub(in crate::results) fn parameter_names(rows: &[SummaryRow]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in rows.iter().flat_map(|r| &r.parameters) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    names
}

pub(in crate::results) fn parameter<'a>(row: &'a SummaryRow, name: &str) -> Option<&'a ParamValue> {
    row.parameters.iter().find(|(n, _)| n == name).map(|(_, v)| v)
}

fn parameter_series(name: &str, kind: ParameterType, rows: &[SummaryRow]) -> Series {
    let values = rows.iter().map(|r| parameter(r, name));
    let whole = |v: &ParamValue| if let ParamValue::Integer(i) = v { Some(*i) } else { None };
    match kind {
        ParameterType::Whole => Series::new(name.into(), values.map(|v| v.and_then(whole)).collect::<Vec<_>>()),
        ParameterType::Real => {
            Series::new(name.into(), values.map(|v| v.and_then(ParamValue::number)).collect::<Vec<_>>())
        }
        ParameterType::Text => text_series(name, values.map(|v| v.map(ToString::to_string))),
    }
}

/// Text on one line, so that each line of the CSV is a run for simple tools; empty text is an empty
/// cell.
fn text_series(name: &str, values: impl Iterator<Item = Option<String>>) -> Series {
    let on_one_line = |text: String| text.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let cells = values.map(|v| v.map(on_one_line).filter(|t| !t.is_empty()));
    Series::new(name.into(), cells.collect::<Vec<Option<String>>>())
}

/// Counts stay whole numbers.
fn metric_series(column: &crate::metrics::Column, rows: &[SummaryRow]) -> Series {
    let cells = rows.iter().map(|row| row.cell(column));
    if column.is_count {
        let counts = cells.map(|cell| if let Measure::Count(n) = cell { Some(n) } else { None });
        Series::new(column.name.into(), counts.collect::<Vec<Option<u64>>>())
    } else {
        let reals = cells.map(|cell| if let Measure::Real(x) = cell { Some(x) } else { None });
        Series::new(column.name.into(), reals.collect::<Vec<Option<f64>>>())
    }
}
