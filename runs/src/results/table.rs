//! Table of runs for a terminal.

use std::fmt::Write;

use crate::results::SummaryRow;
use crate::results::is_truth;
use crate::results::summary::{parameter, parameter_names};
use crate::results::verdict_table::brief_parameters;
use crate::sim::Outcome;
use crate::text::text_table::{self, Alignment, TextTable};
use crate::text::visible::visible;

/// Longest cell of text; longer ones end in an ellipsis.
const WIDEST: usize = 32;

/// One aligned line per run: parameters, outcome, times, contact states tested, final height of the
/// base. Scenarios that sweep other parameters have a header of their own.
pub fn table(rows: &[SummaryRow], width: usize) -> String {
    let swept = |row: &SummaryRow| row.parameters.iter().map(|(n, _)| n.clone()).collect::<Vec<_>>();
    let blocks = rows.chunk_by(|a, b| a.scenario == b.scenario || swept(a) == swept(b));
    blocks.map(|block| lines(block, width)).collect::<Vec<_>>().join("\n")
}

/// A line with the reason for each run that did not simply pass; `all`: also for those that ended
/// as expected.
pub fn endings<'a>(rows: impl IntoIterator<Item = &'a SummaryRow>, all: bool) -> String {
    let mut out = String::new();
    let is_listed = |r: &&SummaryRow| r.outcome != Outcome::Passed && !r.message.is_empty() && (all || r.is_refused());
    for row in rows.into_iter().filter(is_listed) {
        let parameters = brief_parameters(row, |_| true);
        let parameters = if parameters.is_empty() { parameters } else { format!(" ({parameters})") };
        let (scenario, reason) = (visible(&row.scenario), one_line(&row.message));
        // A String takes every write.
        let _ = writeln!(out, "{} {scenario} {}{parameters}: {}", row.outcome.name(), row.key, visible(&reason));
    }
    out
}

/// A column for each swept parameter where there is room, else one for all of them.
fn lines(rows: &[SummaryRow], width: usize) -> String {
    let mut names = parameter_names(rows);
    // The table of verdicts shows swept true values.
    names.retain(|name| !is_truth(name));
    let value = |row: &SummaryRow, name: &&str| parameter(row, name).map_or_else(String::new, |v| clip(&v.to_string()));
    let wide = of_columns(rows, names.iter().map(|n| clip(n)), |row| names.iter().map(|n| value(row, n)).collect());
    if names.is_empty() || wide.natural_width() <= width {
        return wide.render(width);
    }
    of_columns(rows, ["parameters".to_owned()], |row| vec![brief_parameters(row, |_| true)]).render(width)
}

fn of_columns(
    rows: &[SummaryRow],
    parameters: impl IntoIterator<Item = String>,
    cells_of: impl Fn(&SummaryRow) -> Vec<String>,
) -> TextTable {
    let text = ["method", "outcome"].map(|name| (name.to_owned(), Alignment::Left));
    let numbers =
        ["sim s", "wall s", "x real time", "states/test", "final z m"].map(|n| (n.to_owned(), Alignment::Right));
    let parameters = parameters.into_iter().map(|name| (name, Alignment::Left));
    let header = [("scenario".to_owned(), Alignment::Left)].into_iter().chain(parameters).chain(text).chain(numbers);
    let mut table = TextTable::new(header);
    for row in rows {
        let m = &row.metrics;
        let mut cells = vec![clip(&row.scenario)];
        cells.extend(cells_of(row));
        cells.extend([clip(&row.method), row.outcome.name().to_owned()]);
        cells.push(format!("{:.3}", m.duration_s));
        cells.push(format!("{:.3}", row.wall_s));
        cells.push(format!("{:.1}", row.real_time_factor));
        cells.push(m.states_tested_mean().map_or("-".to_owned(), |mean| format!("{mean:.2}")));
        cells.push(height(m.final_base_position[2]));
        table.push(cells);
    }
    table
}

/// A height in tenths of millimetres; with an exponent where a run has diverged.
fn height(z: f64) -> String {
    if z.abs() < 1e6 { format!("{z:.4}") } else { text_table::significant(z, 3) }
}

pub(in crate::results) fn clip(text: &str) -> String {
    text_table::clip(&one_line(&visible(text)), WIDEST)
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
