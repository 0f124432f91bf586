//! Table of verdicts for a terminal.

use std::fmt::Write;

use crate::math;
use crate::results::is_truth;
use crate::results::{SummaryRow, Verdict};
use crate::text::text_table::{Alignment, TextTable, clip, significant};
use crate::text::visible::visible;

/// Longest list of a run's parameters; longer ones end in an ellipsis.
const WIDEST: usize = 48;

/// Digits of values; values of failed verdicts have as many as show the error.
const DIGITS: usize = 6;

/// Verdicts listed in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ListedVerdicts {
    /// Those that did not hold.
    Failed,
    /// Those that did not hold, and all with an expected value.
    Values,
    /// All.
    All,
}

impl ListedVerdicts {
    fn lists(self, verdict: &Verdict) -> bool {
        !verdict.held
            || match self {
                ListedVerdicts::Failed => false,
                ListedVerdicts::Values => verdict.truth.is_some(),
                ListedVerdicts::All => true,
            }
    }
}

/// For each run its name, and below it a line per verdict: metric, measured and expected value,
/// error, relative error, what was allowed, and whether it held. The last line counts. Empty where
/// nothing was expected.
pub fn verdicts<'a>(
    rows: impl IntoIterator<Item = &'a SummaryRow> + Clone,
    listed: ListedVerdicts,
    width: usize,
) -> String {
    let all = rows.clone().into_iter().map(|row| row.verdicts.len()).sum::<usize>();
    if all == 0 {
        return String::new();
    }
    // The metric is indented below its run.
    let numbers = ["measured", "expected", "error", "relative", "allowed", "held"].map(|name| (name, Alignment::Right));
    let mut table = TextTable::new([("  metric", Alignment::Left)].into_iter().chain(numbers));
    let mut runs = Vec::new();
    for row in rows.clone() {
        let lines: Vec<_> = row.verdicts.iter().filter(|v| listed.lists(v)).map(cells).collect();
        if !lines.is_empty() {
            let name = format!("{} {}", visible(&row.scenario), brief_parameters(row, |_| true));
            runs.push((clip(name.trim_end(), width), lines.len()));
            lines.into_iter().for_each(|line| table.push(line));
        }
    }
    let mut out = String::new();
    if table.rows() > 0 {
        let text = table.render(width);
        let mut lines = text.split_inclusive('\n');
        out.extend(lines.next());
        for (name, count) in runs {
            // A String takes every write.
            let _ = writeln!(out, "{name}");
            out.extend(lines.by_ref().take(count));
        }
    }
    let held = rows.into_iter().flat_map(|row| &row.verdicts).filter(|v| v.held).count();
    let hidden = match all - table.rows() {
        0 => String::new(),
        hidden => format!("; {hidden} not shown here, see --verdicts"),
    };
    let _ = writeln!(out, "{held} of {all} expectations held{hidden}");
    out
}

fn cells(verdict: &Verdict) -> Vec<String> {
    let digits = digits(verdict);
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| trimmed(&significant(x, digits)));
    let short = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.1e}"));
    let expected = match (verdict.truth, verdict.min, verdict.max) {
        (Some(_), ..) => number(verdict.truth),
        (None, Some(min), Some(max)) => format!("{min:?}..{max:?}"),
        (None, Some(min), None) => format!(">= {min:?}"),
        (None, None, Some(max)) => format!("<= {max:?}"),
        (None, None, None) => "-".to_owned(),
    };
    let truth = verdict.truth.filter(|t| *t != 0.0);
    vec![
        format!("  {}", verdict.metric),
        number(verdict.measured),
        expected,
        short(verdict.error),
        short(verdict.error.and_then(|e| Some((e / truth?).abs()))),
        short(verdict.allowed),
        if verdict.held { "yes".into() } else { "NO".into() },
    ]
}

/// Removes trailing zeros of a decimal fraction.
fn trimmed(number: &str) -> String {
    let (fraction, exponent) = number.split_at(number.find('e').unwrap_or(number.len()));
    let digits = if fraction.contains('.') { fraction.trim_end_matches('0').trim_end_matches('.') } else { fraction };
    format!("{digits}{exponent}")
}

/// Digits of a verdict's values; a failed verdict shows two digits of its error.
fn digits(verdict: &Verdict) -> usize {
    match (verdict.measured, verdict.error) {
        (Some(measured), Some(error)) if !verdict.held && error != 0.0 && measured.is_finite() => {
            let needed = math::log10((measured / error).abs()).ceil() + 2.0;
            needed.clamp(DIGITS as f64, 17.0) as usize
        }
        _ => DIGITS,
    }
}

/// The selected swept values, by the last part of their names unless two share it. Swept true
/// values are omitted.
pub(in crate::results) fn brief_parameters(row: &SummaryRow, selected: impl Fn(&str) -> bool) -> String {
    // `rpy.1` of `floor.rpy.1`, `force` of `force.0.force`.
    let last = |name: &str| {
        let starts_name = |i: usize| !name[i + 1..].starts_with(|d: char| d.is_ascii_digit());
        let dot = name.char_indices().rev().find(|&(i, c)| c == '.' && starts_name(i));
        name[dot.map_or(0, |(i, _)| i + 1)..].to_owned()
    };
    let named: Vec<_> = row.parameters.iter().filter(|(name, _)| !is_truth(name) && selected(name)).collect();
    let short = |name: &str| {
        let alone = named.iter().filter(|(other, _)| last(other) == last(name)).count() == 1;
        if alone { last(name) } else { name.to_owned() }
    };
    let text =
        named.iter().map(|(name, value)| format!("{}={}", short(name), value.brief())).collect::<Vec<_>>().join(" ");
    clip(&visible(&text), WIDEST)
}
