//! Time series of a log as tables: CSV, Parquet, and text for gnuplot and its like.
//!
//! ```text
//! Trajectory -> columns (named, with units) -> chosen ones -> at chosen instants -> DataTable -> a file
//! ```

mod columns;
mod error;
mod instants;
mod number_format;
mod options;
mod select;
mod table;
mod text;

pub use error::ExportError;
pub use number_format::NumberFormat;
pub use options::{separator, visible};
pub use table::{DataTable, Values};
pub use text::{Header, TextFormat, TimeUnit};

use crate::files::{RecordError, atomic};
use crate::log::Trajectory;
use std::io::Write;
use std::path::Path;

/// What of a log is wanted. By default everything, as it was logged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Names of columns, in which `*` stands for any characters and `?` for one; all columns when there are none. The time
    /// always comes first.
    pub columns: Vec<String>,
    /// Rows per simulated second, Hz; the instants of the log when not given.
    pub rate: Option<f64>,
    /// First instant, s.
    pub from: Option<f64>,
    /// Last instant, s.
    pub to: Option<f64>,
}

/// How a table is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Format {
    /// Comma-separated values with a header, shortest numbers that read back to the same.
    Csv,
    /// Parquet.
    Parquet,
    /// Columns of text.
    Text(TextFormat),
}

/// Names of the columns a log has, the time first.
pub fn column_names(log: &Trajectory) -> Vec<String> {
    std::iter::once(columns::TIME.to_owned()).chain(columns::of(log).into_iter().map(|c| c.name)).collect()
}

/// The chosen columns at the chosen instants.
///
/// Between two ticks of the log, numbers are interpolated linearly, the orientation on the shortest arc (roll, pitch and
/// yaw are those of the interpolated orientation), and words and flags are those of the tick before. At a tick the values
/// are the log's, to the last bit.
///
/// # Errors
/// A column that the log does not have, instants outside of the log, or a log without time series.
pub fn series(log: &Trajectory, selection: &Selection) -> Result<DataTable, ExportError> {
    let chosen = select::choose(columns::of(log), &selection.columns)?;
    let (times, samples) = instants::choose(&log.times, selection)?;
    let mut table = DataTable::default();
    table.push(columns::TIME, Values::Real(times.into_iter().map(Some).collect()));
    for column in chosen {
        table.push(column.name.clone(), column.values(&samples));
    }
    Ok(table)
}

/// The events of a log: when, what kind, of what, in words. Of a selection the limits in time are heeded.
pub fn events(log: &Trajectory, selection: &Selection) -> DataTable {
    let (from, to) = (selection.from.unwrap_or(f64::NEG_INFINITY), selection.to.unwrap_or(f64::INFINITY));
    let chosen = || log.events.iter().filter(|e| (from..=to).contains(&e.time));
    let mut table = DataTable::default();
    table.push(columns::TIME, Values::Real(chosen().map(|e| Some(e.time)).collect()));
    table.push("kind", Values::Text(chosen().map(|e| e.kind.clone()).collect()));
    table.push("subject", Values::Text(chosen().map(|e| e.subject.clone()).collect()));
    table.push("message", Values::Text(chosen().map(|e| e.message.clone()).collect()));
    table
}

/// Writes a table beside `path` and renames it there: a file that is there is whole.
///
/// # Errors
/// The folder or file cannot be written, or the format asks for a column that the table does not have.
pub fn write(table: &DataTable, format: &Format, path: &Path) -> Result<(), ExportError> {
    let bytes = to_bytes(table, format)?;
    Ok(atomic::write_named(path, atomic::Made::Table, |out| out.write_all(&bytes).map_err(RecordError::io(path)))?)
}

/// The table as bytes.
///
/// # Errors
/// The format asks for a column that the table does not have.
pub fn to_bytes(table: &DataTable, format: &Format) -> Result<Vec<u8>, ExportError> {
    let mut bytes = Vec::new();
    match format {
        Format::Csv => table.write_csv(&mut bytes)?,
        Format::Parquet => table.write_parquet(&mut bytes)?,
        Format::Text(text) => text.write(table, &mut bytes)?,
    }
    Ok(bytes)
}
