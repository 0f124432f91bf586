//! Writes `summary.csv` and `summary.parquet`, one row per run, in parts: a million rows need no
//! more memory than thousands.

use crate::files::names;
use crate::files::{RecordError, atomic};
use crate::metrics::{COLUMNS, Measure};
use crate::results::summary::summary_row::{TEXT_COLUMNS, truth_columns, truth_error};
use crate::results::{ParamValue, SummaryRow};
use polars::prelude::{Column, CompatLevel, DataFrame, NamedFrom, PolarsError, PolarsResult, Series};
use polars_io::SerWriter;
use polars_io::csv::write::CsvWriter;
use polars_io::parquet::write::{BatchedWriter, ParquetWriter};
use polars_parquet::write::{Encoding, row_group_iter};
use rayon::prelude::*;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::PoisonError;

/// Rows in memory at a time.
const PART: usize = 8192;

/// Rows below which columns have no dictionaries in Parquet: polars estimates the size of each, which
/// takes as long for one row as for thousands.
const FEW: usize = 512;

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
    let mut columns = SummaryColumns::default();
    rows.for_each(&mut |row| {
        columns.add(row);
        Ok(())
    })?;
    columns.write(folder, rows)
}

/// The columns that depend on the rows. They are empty where a row lacks a value.
#[derive(Debug, Default)]
pub struct SummaryColumns {
    /// Swept parameters of all rows, in the order of first appearance.
    parameters: Vec<(String, ParameterType)>,
    /// Columns of distances from truths, in the order of first appearance.
    truths: Vec<String>,
}

/// Type of a parameter's column; each type can represent the values of those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ParameterType {
    Whole,
    Real,
    Text,
}

impl SummaryColumns {
    /// Adds the columns of a row.
    pub fn add(&mut self, row: &SummaryRow) {
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

    /// Writes the summary of rows whose columns were added. In a pool of one thread no other one takes
    /// part; else polars takes those of all processors for parts of 512 rows and more.
    ///
    /// # Errors
    /// See [`write_summary_of`].
    pub fn write(&self, folder: &Path, rows: &dyn Rows) -> Result<SummaryFiles, RecordError> {
        let files = SummaryFiles { csv: folder.join(names::SUMMARY_CSV), parquet: folder.join(names::SUMMARY_PARQUET) };
        let failure = |path: &Path| {
            let path = path.to_owned();
            move |source: PolarsError| RecordError::Summary { path, source: source.into() }
        };
        let empty = Cells::new(self).frame().map_err(failure(&files.csv))?;
        let (schema, threads) = (empty.schema(), rayon::current_num_threads());
        atomic::write(&files.csv, |csv| {
            atomic::write(&files.parquet, |parquet| {
                let mut csv = CsvWriter::new(csv).n_threads(threads).batched(schema).map_err(failure(&files.csv))?;
                let mut parquet = ParquetWriter::new(parquet)
                    .set_parallel(threads > 1)
                    .batched(schema)
                    .map_err(failure(&files.parquet))?;
                let mut write = |cells: Cells| {
                    let frame = cells.frame().map_err(failure(&files.csv))?;
                    let (text, binary) = rayon::join(
                        || csv.write_batch(&frame),
                        || {
                            if frame.height() < FEW {
                                write_plain(&parquet, &frame)
                            } else {
                                parquet.write_batch(&frame)
                            }
                        },
                    );
                    text.map_err(failure(&files.csv))?;
                    binary.map_err(failure(&files.parquet))
                };
                let mut cells = Cells::new(self);
                rows.for_each(&mut |row| {
                    cells.push(row);
                    if cells.rows() < PART { Ok(()) } else { write(std::mem::replace(&mut cells, Cells::new(self))) }
                })?;
                if cells.rows() > 0 {
                    write(cells)?;
                }
                csv.finish().map_err(failure(&files.csv))?;
                parquet.finish().map(|_| ()).map_err(failure(&files.parquet))
            })
        })?;
        Ok(files)
    }
}

/// Appends rows in plain encoding.
fn write_plain<W: Write>(parquet: &BatchedWriter<W>, frame: &DataFrame) -> PolarsResult<()> {
    let mut file = parquet.get_writer().lock().unwrap_or_else(PoisonError::into_inner);
    let (options, fields) = (file.options(), file.parquet_schema().fields().to_vec());
    let encodings = vec![vec![Encoding::Plain]; frame.width()];
    for rows in frame.iter_chunks(CompatLevel::newest(), false) {
        let count = rows.len() as u64;
        file.write(count, row_group_iter(rows, encodings.clone().into(), fields.clone(), options))?;
    }
    Ok(())
}

/// A part of the summary: identity and `seed`; swept parameters; metrics; distances from known
/// truths.
struct Cells<'a> {
    columns: &'a SummaryColumns,
    texts: Vec<Vec<Option<String>>>,
    seeds: Vec<u64>,
    parameters: Vec<Vec<Option<ParamValue>>>,
    /// Those of [`COLUMNS`].
    metrics: Vec<Numbers>,
    truths: Vec<Vec<Option<f64>>>,
}

/// Counts stay whole numbers.
enum Numbers {
    Counts(Vec<Option<u64>>),
    Reals(Vec<Option<f64>>),
}

impl Numbers {
    fn push(&mut self, cell: Measure) {
        match self {
            Numbers::Counts(list) => list.push(if let Measure::Count(n) = cell { Some(n) } else { None }),
            Numbers::Reals(list) => list.push(if let Measure::Real(x) = cell { Some(x) } else { None }),
        }
    }

    fn series(self, name: &str) -> Series {
        match self {
            Numbers::Counts(list) => Series::new(name.into(), list),
            Numbers::Reals(list) => Series::new(name.into(), list),
        }
    }
}

impl<'a> Cells<'a> {
    fn new(columns: &'a SummaryColumns) -> Self {
        let numbers = |is_count| if is_count { Numbers::Counts(Vec::new()) } else { Numbers::Reals(Vec::new()) };
        Cells {
            columns,
            texts: vec![Vec::new(); TEXT_COLUMNS.len()],
            seeds: Vec::new(),
            parameters: vec![Vec::new(); columns.parameters.len()],
            metrics: COLUMNS.iter().map(|column| numbers(column.is_count)).collect(),
            truths: vec![Vec::new(); columns.truths.len()],
        }
    }

    fn rows(&self) -> usize {
        self.seeds.len()
    }

    fn push(&mut self, row: &SummaryRow) {
        for (list, column) in self.texts.iter_mut().zip(TEXT_COLUMNS) {
            list.push(on_one_line((column.get)(row)));
        }
        self.seeds.push(row.seed);
        for (list, (name, _)) in self.parameters.iter_mut().zip(&self.columns.parameters) {
            list.push(parameter(row, name).cloned());
        }
        self.metrics.iter_mut().zip(&COLUMNS).for_each(|(list, column)| list.push(row.cell(column)));
        for (list, name) in self.truths.iter_mut().zip(&self.columns.truths) {
            list.push(truth_error(row, name));
        }
    }

    fn frame(self) -> PolarsResult<DataFrame> {
        let rows = self.rows();
        let texts = TEXT_COLUMNS.iter().zip(self.texts).map(|(c, cells)| Series::new(c.name.into(), cells));
        let seed = Series::new("seed".into(), self.seeds);
        let parameters = self.columns.parameters.iter().zip(self.parameters);
        let parameters = parameters.map(|((name, kind), values)| parameter_series(name, *kind, &values));
        let metrics = COLUMNS.par_iter().zip(self.metrics).map(|(column, numbers)| numbers.series(column.name));
        let metrics: Vec<Series> = metrics.collect();
        let truths = self.columns.truths.iter().zip(self.truths);
        let truths = truths.map(|(name, errors)| Series::new(name.as_str().into(), errors));
        let all = texts.chain([seed]).chain(parameters).chain(metrics).chain(truths).map(Column::from).collect();
        DataFrame::new(rows, all)
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

fn parameter_series(name: &str, kind: ParameterType, values: &[Option<ParamValue>]) -> Series {
    let values = values.iter().map(Option::as_ref);
    let whole = |v: &ParamValue| if let ParamValue::Integer(i) = v { Some(*i) } else { None };
    match kind {
        ParameterType::Whole => Series::new(name.into(), values.map(|v| v.and_then(whole)).collect::<Vec<_>>()),
        ParameterType::Real => {
            Series::new(name.into(), values.map(|v| v.and_then(ParamValue::number)).collect::<Vec<_>>())
        }
        ParameterType::Text => {
            let cells = values.map(|v| v.and_then(|v| on_one_line(&v.to_string())));
            Series::new(name.into(), cells.collect::<Vec<_>>())
        }
    }
}

/// A cell of text on one line, so that each line of the CSV is a run for simple tools; empty text
/// is an empty cell.
fn on_one_line(text: &str) -> Option<String> {
    let mut lines = text.lines().map(str::trim);
    let first = lines.next()?;
    let cell = lines.fold(first.to_owned(), |cell, line| cell + " " + line);
    Some(cell).filter(|cell| !cell.is_empty())
}
