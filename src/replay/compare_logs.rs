//! Compares the logs of a run and its re-run, bit for bit.

use crate::export::{DataTable, Selection, Values, events, series};
use crate::files::names;
use crate::log::{LogError, Trajectory, read_bytes};
use crate::replay::difference::Difference;
use std::path::Path;

/// The first difference; none if the files are equal or, with changed inputs, if series and events
/// are. The log of a run that was `terminated` externally may be a beginning of the other.
pub(super) fn compare(then: &Path, now: &Path, inputs_changed: bool, terminated: bool) -> Option<Difference> {
    let invalid_then = |error: LogError| difference("as a whole", error, "a valid log");
    let invalid_now = |error: LogError| difference("as a whole", "a valid log", error);
    let compare = || {
        let (a, b) = (read_bytes(then).map_err(invalid_then)?, read_bytes(now).map_err(invalid_now)?);
        if a == b {
            return Ok(None);
        }
        let a = Trajectory::from_bytes(then, &a).map_err(invalid_then)?;
        let b = Trajectory::from_bytes(now, &b).map_err(invalid_now)?;
        Ok(compare_contents(&a, &b, inputs_changed, terminated))
    };
    compare().unwrap_or_else(Some)
}

fn compare_contents(then: &Trajectory, now: &Trajectory, inputs_changed: bool, terminated: bool) -> Option<Difference> {
    let all = Selection::default();
    let tables = |log: &Trajectory| (series(log, &all).unwrap_or_default(), events(log, &all));
    let ((series_then, events_then), (series_now, events_now)) = (tables(then), tables(now));
    let ticks = rows(&series_then, &series_now, "tick", terminated);
    let events = rows(&events_then, &events_now, "event", terminated);
    let first = [ticks, events].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((_, difference)) = first {
        return Some(difference);
    }
    if terminated || inputs_changed {
        return None;
    }
    let different_text = then.attachments.iter().zip(&now.attachments).find(|(a, b)| a != b);
    match different_text {
        Some((a, b)) => Some(difference("attached text", &a.name, format!("another {}", b.name))),
        None if then.complete != now.complete => {
            let completeness = |complete| if complete { "a complete log" } else { "one that ends early" };
            Some(difference("as a whole", completeness(then.complete), completeness(now.complete)))
        }
        None => {
            let position = "series and events are equal; drawn shapes or message descriptions differ";
            Some(Difference { file: names::LOG, position: position.to_owned(), values: None, more: 0 })
        }
    }
}

/// The first row with a difference between two tables: its time and the difference.
fn rows(then: &DataTable, now: &DataTable, what: &str, terminated: bool) -> Option<(f64, Difference)> {
    let pairs: Vec<_> = then.columns().iter().map(|(name, a)| (name, a, now.column(name))).collect();
    let time = |table: &DataTable, row: usize| match table.columns().first() {
        Some((_, Values::Real(times))) => times.get(row).copied().flatten().unwrap_or(f64::NAN),
        _ => f64::NAN,
    };
    for row in 0..then.rows().min(now.rows()) {
        let position = |name: &str| format!("at {:?} s, `{name}`", time(then, row));
        for (name, a, b) in &pairs {
            let (a, b) = (cell(a, row), b.map_or_else(|| "no such column".to_owned(), |b| cell(b, row)));
            if a != b {
                return Some((time(then, row), difference(position(name), a, b)));
            }
        }
    }
    let (a, b) = (then.rows(), now.rows());
    if a == b || (terminated && a < b) {
        return None;
    }
    let (longer, count) = if a > b { (then, b) } else { (now, a) };
    let counted = |n: usize| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
    let first = time(longer, count);
    Some((first, difference(format!("from {first} s on"), counted(a), counted(b))))
}

/// The text of a cell; different values have different texts.
fn cell(values: &Values, row: usize) -> String {
    match values {
        Values::Real(v) => v[row].map_or_else(|| "nothing".to_owned(), |x| format!("{x:?}")),
        Values::Text(v) => v[row].clone(),
        Values::Flag(v) => v[row].to_string(),
    }
}

fn difference(position: impl ToString, then: impl ToString, now: impl ToString) -> Difference {
    let values = Some((then.to_string(), now.to_string()));
    Difference { file: names::LOG, position: position.to_string(), values, more: 0 }
}
