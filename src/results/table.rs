//! The table a person sees at the end of a batch.

use crate::results::SummaryRow;
use crate::results::is_truth;
use crate::results::summary::{parameter, parameter_names};
use crate::sim::Outcome;
use crate::text::visible::visible;
use std::fmt::Write;

/// Longest cell of text; longer ones end in an ellipsis.
const WIDEST: usize = 32;

/// One aligned line per run: what it was, how it ended, how long it took, how hard the contact was, where the base came
/// to rest; scenarios that sweep other parameters stand under a header of their own. Below, a line for each run that did
/// not simply pass and says why.
pub fn table(rows: &[SummaryRow]) -> String {
    let swept = |row: &SummaryRow| row.parameters.iter().map(|(n, _)| n.clone()).collect::<Vec<_>>();
    let mut out = String::new();
    for block in rows.chunk_by(|a, b| a.scenario == b.scenario || swept(a) == swept(b)) {
        if !out.is_empty() {
            out.push('\n');
        }
        out += &lines(block);
    }
    for row in rows.iter().filter(|r| r.outcome != Outcome::Passed && !r.message.is_empty()) {
        // A String takes every write.
        let (scenario, words) = (visible(&row.scenario), one_line(&row.message));
        let _ = writeln!(out, "{} {scenario} {}: {}", row.outcome.name(), row.key, visible(&words));
    }
    out
}

fn lines(rows: &[SummaryRow]) -> String {
    let mut names = parameter_names(rows);
    // Swept truths are told with their verdicts.
    names.retain(|name| !is_truth(name));
    let mut header: Vec<String> = vec!["scenario".into()];
    header.extend(names.iter().map(|n| clip(n)));
    header
        .extend(["method", "outcome", "sim s", "wall s", "x real time", "states/test", "final z m"].map(String::from));
    let lines: Vec<Vec<String>> = std::iter::once(header).chain(rows.iter().map(|r| cells(r, &names))).collect();
    // Words to the left, numbers to the right.
    let numeric_from = names.len() + 3;
    align(&lines, numeric_from)
}

/// Pads cells to columns two spaces apart, those from `numeric_from` on to the right.
pub(crate) fn align(lines: &[Vec<String>], numeric_from: usize) -> String {
    let widths: Vec<usize> =
        (0..lines[0].len()).map(|c| lines.iter().map(|l| l[c].chars().count()).max().unwrap_or(0)).collect();
    let mut out = String::new();
    for line in lines {
        let padded: Vec<String> = line
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(c, (cell, &w))| if c < numeric_from { format!("{cell:<w$}") } else { format!("{cell:>w$}") })
            .collect();
        out.push_str(padded.join("  ").trim_end());
        out.push('\n');
    }
    out
}

fn cells(row: &SummaryRow, names: &[&str]) -> Vec<String> {
    let m = &row.metrics;
    let mut cells = vec![clip(&row.scenario)];
    cells.extend(names.iter().map(|n| parameter(row, n).map_or_else(String::new, |v| clip(&v.to_string()))));
    cells.push(clip(&row.method));
    cells.push(row.outcome.name().to_owned());
    cells.push(format!("{:.3}", m.duration_s));
    cells.push(format!("{:.3}", row.wall_s));
    cells.push(format!("{:.1}", row.real_time_factor));
    cells.push(m.states_tested_mean().map_or("-".to_owned(), |mean| format!("{mean:.2}")));
    cells.push(format!("{:.4}", m.final_base_position[2]));
    cells
}

pub(crate) fn clip(text: &str) -> String {
    let text = one_line(&visible(text));
    if text.chars().count() <= WIDEST { text } else { text.chars().take(WIDEST - 1).chain(['…']).collect() }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
