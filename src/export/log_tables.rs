//! Tables of the time series and of the events of a log.

use crate::export::data_table::{DataTable, Values};
use crate::export::export_error::ExportError;
use crate::export::log_columns::{self, TIME};
use crate::export::selection::Selection;
use crate::export::{column_choice, log_instants};
use crate::log::Trajectory;

/// Names of the columns of a log, the time first.
pub fn column_names(log: &Trajectory) -> Vec<String> {
    std::iter::once(TIME.to_owned()).chain(log_columns::of(log).into_iter().map(|c| c.name)).collect()
}

/// The selected columns at the selected instants.
///
/// Between two ticks of the log, numbers are interpolated linearly and orientations along the
/// shortest arc; roll, pitch and yaw are those of the interpolated orientation. Texts and flags are
/// those of the tick before. At a tick the values are those of the log, to the last bit.
///
/// # Errors
/// An unknown column, instants outside the log, or a log without time series.
pub fn series(log: &Trajectory, selection: &Selection) -> Result<DataTable, ExportError> {
    let chosen = column_choice::choose(log_columns::of(log), &selection.columns)?;
    let (times, instants) = log_instants::choose(&log.times, selection)?;
    let mut table = DataTable::default();
    table.push(TIME, Values::Real(times.into_iter().map(Some).collect()));
    for column in chosen {
        table.push(column.name.clone(), column.values(&instants));
    }
    Ok(table)
}

/// The events of a log with time, kind, subject and message. Of the selection only the limits in
/// time apply.
pub fn events(log: &Trajectory, selection: &Selection) -> DataTable {
    let (from, to) = (selection.from.unwrap_or(f64::NEG_INFINITY), selection.to.unwrap_or(f64::INFINITY));
    let chosen = || log.events.iter().filter(|e| (from..=to).contains(&e.time));
    let mut table = DataTable::default();
    table.push(TIME, Values::Real(chosen().map(|e| Some(e.time)).collect()));
    table.push("kind", Values::Text(chosen().map(|e| e.kind.clone()).collect()));
    table.push("subject", Values::Text(chosen().map(|e| e.subject.clone()).collect()));
    table.push("message", Values::Text(chosen().map(|e| e.message.clone()).collect()));
    table
}
