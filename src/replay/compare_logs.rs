//! Compares the logs of a run and its re-run, bit for bit.

use crate::export::{DataTable, Selection, Values, events, series};
use crate::files::input;
use crate::files::names;
use crate::log::{LogError, Trajectory};
use crate::replay::difference::Difference;
use std::path::Path;

/// The first difference; none if the files are equal or, with changed inputs, if series and events are. The log of a run
/// that was `terminated` externally may be a beginning of the other.
pub(super) fn compare(then: &Path, now: &Path, inputs_changed: bool, terminated: bool) -> Option<Difference> {
    let bytes = |path: &Path| input::read(path, input::UNLIMITED);
    let read = |path: &Path| bytes(path).map_err(|source| LogError::Io { path: path.to_owned(), source });
    match (read(then), read(now)) {
        (Ok(a), Ok(b)) if a == b => None,
        (Ok(a), Ok(b)) => match (Trajectory::from_bytes(then, &a), Trajectory::from_bytes(now, &b)) {
            (Ok(a), Ok(b)) => compare_contents(&a, &b, inputs_changed, terminated),
            (Err(error), _) => Some(difference("as a whole", error, "a sound log")),
            (_, Err(error)) => Some(difference("as a whole", "a sound log", error)),
        },
        (Err(error), _) => Some(difference("as a whole", error, "a sound log")),
        (_, Err(error)) => Some(difference("as a whole", "a sound log", error)),
    }
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
            let words = |complete| if complete { "a complete log" } else { "one that ends early" };
            Some(difference("as a whole", words(then.complete), words(now.complete)))
        }
        None => {
            let position = "series and events are equal; drawn shapes or descriptions of messages are not";
            Some(Difference { file: names::LOG, position: position.to_owned(), values: None, more: 0 })
        }
    }
}

/// The first row of two tables with a difference: its time, and what it is.
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
    let words = |n: usize| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
    let first = time(longer, count);
    Some((first, difference(format!("from {first} s on"), words(a), words(b))))
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
