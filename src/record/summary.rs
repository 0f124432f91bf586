//! `summary.csv` and `summary.parquet`: one row per run.

use super::columns::{COLUMNS, Number, TEXT_COLUMNS, truth_columns, truth_error};
use super::{ParamValue, RecordError, SummaryRow, atomic};
use polars::prelude::{Column, DataFrame, NamedFrom, PolarsResult, Series};
use polars_io::SerWriter;
use polars_io::csv::write::CsvWriter;
use polars_io::parquet::write::ParquetWriter;
use std::path::{Path, PathBuf};

/// Where the summary was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SummaryFiles {
    /// `summary.csv`.
    pub csv: PathBuf,
    /// `summary.parquet`.
    pub parquet: PathBuf,
}

/// Writes `summary.csv` and `summary.parquet` into `folder`, one row per run in the order given.
///
/// # Errors
/// The folder or a file cannot be written, or a swept parameter has the name of a column.
pub fn write_summary(folder: &Path, rows: &[SummaryRow]) -> Result<SummaryFiles, RecordError> {
    let files = SummaryFiles { csv: folder.join("summary.csv"), parquet: folder.join("summary.parquet") };
    let failure = |path: &Path| {
        let path = path.to_owned();
        move |source| RecordError::Summary { path, source }
    };
    let mut frame = summary_frame(rows).map_err(failure(&files.csv))?;
    atomic::write(&files.csv, |out| CsvWriter::new(out).finish(&mut frame).map_err(failure(&files.csv)))?;
    atomic::write(&files.parquet, |out| {
        ParquetWriter::new(out).finish(&mut frame).map(|_| ()).map_err(failure(&files.parquet))
    })?;
    Ok(files)
}

/// The summary as a table. Columns: identity and `seed`; the swept parameters of all rows, in the order they are first
/// met, empty where a row lacks one; the metrics; the distances from known truths.
///
/// # Errors
/// A swept parameter has the name of a column.
pub fn summary_frame(rows: &[SummaryRow]) -> PolarsResult<DataFrame> {
    let texts = TEXT_COLUMNS.iter().map(|c| text_series(c.name, rows.iter().map(|r| Some((c.get)(r).to_owned()))));
    let seed = Series::new("seed".into(), rows.iter().map(|r| r.seed).collect::<Vec<_>>());
    let parameters = parameter_names(rows).into_iter().map(|name| parameter_series(name, rows));
    let metrics = COLUMNS.iter().map(|column| metric_series(column.name, column.get, rows));
    let truths = truth_columns(rows).into_iter().map(|name| {
        let errors: Vec<Option<f64>> = rows.iter().map(|row| truth_error(row, &name)).collect();
        Series::new(name.into(), errors)
    });
    let all = texts.chain([seed]).chain(parameters).chain(metrics).chain(truths).map(Column::from).collect();
    DataFrame::new(rows.len(), all)
}

/// Names of all swept parameters, in the order they are first met.
pub(super) fn parameter_names(rows: &[SummaryRow]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in rows.iter().flat_map(|r| &r.parameters) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    names
}

pub(super) fn parameter<'a>(row: &'a SummaryRow, name: &str) -> Option<&'a ParamValue> {
    row.parameters.iter().find(|(n, _)| n == name).map(|(_, v)| v)
}

/// Whole numbers, real numbers or text, whichever holds every value.
fn parameter_series(name: &str, rows: &[SummaryRow]) -> Series {
    let values: Vec<Option<&ParamValue>> = rows.iter().map(|r| parameter(r, name)).collect();
    let every = |test: fn(&ParamValue) -> bool| values.iter().flatten().all(|v| test(v));
    if every(|v| matches!(v, ParamValue::Integer(_))) {
        let whole = |v: &ParamValue| if let ParamValue::Integer(i) = v { Some(*i) } else { None };
        Series::new(name.into(), values.iter().map(|v| v.and_then(whole)).collect::<Vec<_>>())
    } else if every(|v| v.number().is_some()) {
        Series::new(name.into(), values.iter().map(|v| v.and_then(ParamValue::number)).collect::<Vec<_>>())
    } else {
        text_series(name, values.iter().map(|v| v.map(ToString::to_string)))
    }
}

/// Words on one line each, so that a line of the CSV is a run to simple tools; no words are an empty cell.
fn text_series(name: &str, values: impl Iterator<Item = Option<String>>) -> Series {
    let on_one_line = |text: String| text.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let cells = values.map(|v| v.map(on_one_line).filter(|t| !t.is_empty()));
    Series::new(name.into(), cells.collect::<Vec<Option<String>>>())
}

/// Counts stay whole numbers; a column is one or the other throughout.
fn metric_series(name: &str, get: fn(&SummaryRow) -> Number, rows: &[SummaryRow]) -> Series {
    let counts: Option<Vec<u64>> =
        rows.iter().map(|r| if let Number::Count(n) = get(r) { Some(n) } else { None }).collect();
    match counts {
        Some(counts) if !rows.is_empty() => Series::new(name.into(), counts),
        _ => {
            let reals = rows.iter().map(|r| if let Number::Real(x) = get(r) { x } else { None });
            Series::new(name.into(), reals.collect::<Vec<Option<f64>>>())
        }
    }
}
