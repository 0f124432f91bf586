//! Recorded data: columns of a log or of a table over time.

use std::path::Path;

use crate::export::{self, Selection, Values};
use crate::fit::fit_file::FitFile;
use crate::input;
use crate::log::Trajectory;
use crate::text::pattern::matches;
use crate::text::plural::plural;
use crate::text::{Diagnostic, suggest};

/// The channels of a data set: one column each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Instants, s of simulated time, ascending.
    pub times: Vec<f64>,
    /// Index of the signal, column of `runner export`, and a value per instant; NaN where the data
    /// have none.
    pub channels: Vec<Channel>,
}

/// One recorded column.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Index of its signal.
    pub signal: usize,
    /// Name in `runner export`.
    pub column: String,
    /// One value per instant, in the column's unit; NaN: none.
    pub values: Vec<f64>,
}

impl Recording {
    /// Number of values.
    pub fn points(&self) -> usize {
        self.channels.iter().map(|channel| channel.values.iter().filter(|value| value.is_finite()).count()).sum()
    }
}

/// Columns by name, before signals choose among them.
struct Table {
    times: Vec<f64>,
    columns: Vec<(String, Option<Vec<f64>>)>,
}

/// Reads the data at an index of the fit file.
///
/// # Errors
/// The file cannot be read, lacks a column of a signal, or has nothing within `from` and `to`.
pub fn read(fit: &FitFile, index: usize) -> Result<Recording, Box<Diagnostic>> {
    let data = &fit.spec.data[index];
    let key = format!("data.{index}.file");
    let path = fit.resolve(&data.file);
    let refuse = |message: String| fit.error_at(&key, message, None);
    let table = match path.extension().and_then(|e| e.to_str()) {
        Some("mcap") => from_log(&path, fit, index),
        Some("csv") => from_csv(&path, fit, index),
        _ => {
            return Err(refuse(format!("`{key}` must be a log (.mcap) or a table (.csv), not `{}`", data.file)));
        }
    }?;
    let mut recording = Recording { times: table.times, channels: Vec::new() };
    let name = fit.data_name(index);
    for (s, signal) in fit.spec.signal.iter().enumerate() {
        if signal.data.as_ref().is_some_and(|names| !names.contains(&name)) {
            continue;
        }
        let found: Vec<_> = table.columns.iter().filter(|(column, _)| matches(&signal.column, column)).collect();
        let at = format!("signal.{s}.column");
        if found.is_empty() {
            let help = suggest::help(&signal.column, table.columns.iter().map(|(name, _)| name.as_str()).take(50));
            let message = format!("the data `{name}` have no column `{}`", signal.column);
            return Err(fit.error_at(&at, message, Some(help)));
        }
        for (column, values) in found {
            let Some(values) = values else {
                return Err(fit.error_at(&at, format!("`{column}` of the data `{name}` is not a number"), None));
            };
            if recording.channels.iter().any(|channel| channel.column == *column) {
                return Err(fit.error_at(&at, format!("`{column}` is a column of two signals"), None));
            }
            recording.channels.push(Channel { signal: s, column: column.clone(), values: values.clone() });
        }
    }
    let (from, to) = (data.from.unwrap_or(f64::NEG_INFINITY), data.to.unwrap_or(f64::INFINITY));
    let kept: Vec<bool> = recording.times.iter().map(|time| (from..=to).contains(time)).collect();
    let retain = |list: &mut Vec<f64>| {
        let mut keep = kept.iter();
        list.retain(|_| keep.next() == Some(&true));
    };
    retain(&mut recording.times);
    recording.channels.iter_mut().for_each(|channel| retain(&mut channel.values));
    recording.times.iter_mut().for_each(|time| *time += data.offset);
    if recording.points() == 0 {
        return Err(refuse(format!("`{name}` has no values of the signals from {from} s to {to} s")));
    }
    if let Some(early) = recording.times.first().filter(|time| **time < 0.0) {
        let message = format!("`{name}` begins at {early} s of simulated time, before the scenario");
        let key = if data.offset == 0.0 { key.clone() } else { format!("data.{index}.offset") };
        return Err(fit.error_at(&key, message, Some("`offset` or `from` can move or cut it".into())));
    }
    Ok(recording)
}

fn from_log(path: &Path, fit: &FitFile, index: usize) -> Result<Table, Box<Diagnostic>> {
    let refuse = |message: String| fit.error_at(&format!("data.{index}.file"), message, None);
    let log = Trajectory::read(path).map_err(|error| refuse(error.to_string()))?;
    let table = export::series(&log, &Selection::default()).map_err(|error| refuse(error.to_string()))?;
    let real = |values: &Values| match values {
        Values::Real(list) => Some(list.iter().map(|x| x.unwrap_or(f64::NAN)).collect()),
        Values::Text(_) | Values::Flag(_) => None,
    };
    let columns = table.columns().iter().skip(1).map(|(name, values)| (name.clone(), real(values))).collect();
    Ok(Table { times: log.times.clone(), columns })
}

/// Reads a table: a header of names, then one line per instant. Empty cells and `NaN` are absent
/// values; lines that begin with `#` are comments.
fn from_csv(path: &Path, fit: &FitFile, index: usize) -> Result<Table, Box<Diagnostic>> {
    let data = &fit.spec.data[index];
    let key = format!("data.{index}.file");
    let text = input::read_text(path, input::MOST_DATA)
        .map_err(|error| fit.error_at(&key, format!("{}: {error}", path.display()), None))?;
    let name = path.display().to_string();
    let refuse = |cell: &str, message: String| {
        let start = cell.as_ptr() as usize - text.as_ptr() as usize;
        Box::new(Diagnostic::in_text(&name, &text, start..start + cell.len(), message, None))
    };
    let mut lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let Some(header) = lines.next() else {
        let message = "the table is empty: its first line must name the columns";
        return Err(Box::new(Diagnostic::whole_file(&name, message)));
    };
    let names: Vec<&str> = header.split(',').map(unquoted).collect();
    let Some(time) = names.iter().position(|column| *column == data.time) else {
        let help = suggest::help(&data.time, names.iter().copied());
        let message = format!("`{}` has no column `{}` of the time", data.file, data.time);
        return Err(fit.error_at(&format!("data.{index}.time"), message, Some(help)));
    };
    if let Some((ours, theirs)) = data.columns.iter().find(|(_, theirs)| !names.contains(&theirs.as_str())) {
        let help = suggest::help(theirs, names.iter().copied());
        let at = format!("data.{index}.columns.{}", crate::scenario::segment(ours));
        return Err(fit.error_at(&at, format!("`{}` has no column `{theirs}`", data.file), Some(help)));
    }
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    let mut is_number = vec![true; names.len()];
    for line in lines {
        let cells: Vec<&str> = line.split(',').map(unquoted).collect();
        if cells.len() != names.len() {
            return Err(refuse(
                line,
                format!("this line has {}, the header {}", plural(cells.len(), "cell"), names.len()),
            ));
        }
        for (c, cell) in cells.iter().enumerate() {
            let value = match cell.parse::<f64>() {
                _ if cell.is_empty() => f64::NAN,
                Ok(value) if !value.is_infinite() => value,
                // A column of text is an error only if a signal uses it.
                _ => {
                    is_number[c] = false;
                    f64::NAN
                }
            };
            columns[c].push(value);
        }
        let times = &columns[time];
        let now = times[times.len() - 1];
        if !now.is_finite() {
            return Err(refuse(cells[time], format!("the time must be a number, not {:?}", cells[time])));
        }
        if times.len() > 1 && !(now > times[times.len() - 2]) {
            let before = times[times.len() - 2];
            return Err(refuse(cells[time], format!("the time must be after that of the line before, {before}")));
        }
    }
    let ours = |theirs: &str| data.columns.iter().find(|(_, name)| *name == theirs).map(|(ours, _)| ours.clone());
    let times = columns[time].clone();
    let columns = columns.into_iter().zip(&names).zip(is_number).enumerate();
    let columns = columns.filter(|(c, _)| *c != time).map(|(_, ((values, name), is_number))| {
        (ours(name).unwrap_or_else(|| (*name).to_owned()), is_number.then_some(values))
    });
    Ok(Table { times, columns: columns.collect() })
}

/// A cell without blanks and quotes.
fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(cell)
}
