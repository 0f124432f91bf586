//! Verdicts: what was expected of a run, what was measured, and how far apart they are.

use crate::metrics::number;
use crate::results::is_truth;
use crate::results::table::{align, clip};
use crate::results::{ParamValue, SummaryRow};
use crate::text::visible::visible;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Longest list of a run's parameters; a longer one ends in an ellipsis.
const WIDEST: usize = 48;

/// One expectation held against a run. Numbers are in the metric's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// A numeric column of the summary, or `outcome`.
    pub metric: String,
    /// What was measured; none for an outcome, and for what never happened.
    #[serde(with = "number::some_real")]
    #[schemars(with = "crate::results::Measure")]
    pub measured: Option<f64>,
    /// What was wanted; none where there are only limits.
    pub truth: Option<f64>,
    /// Greatest distance from `truth` that holds.
    pub allowed: Option<f64>,
    /// Smallest value that holds.
    pub min: Option<f64>,
    /// Greatest value that holds.
    pub max: Option<f64>,
    /// Measured less wanted; with limits what lies beyond them, 0 between.
    #[serde(with = "number::some_real")]
    #[schemars(with = "crate::results::Measure")]
    pub error: Option<f64>,
    /// Did it hold?
    pub held: bool,
    /// In words why not.
    pub message: String,
}

/// Which verdicts a person sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Those that did not hold.
    Failed,
    /// These, and all that name a value.
    Values,
    /// All.
    All,
}

impl Shown {
    fn shows(self, verdict: &Verdict) -> bool {
        !verdict.held
            || match self {
                Shown::Failed => false,
                Shown::Values => verdict.truth.is_some(),
                Shown::All => true,
            }
    }

    /// How many lines [`verdicts`] would have.
    pub fn count(self, rows: &[SummaryRow]) -> usize {
        rows.iter().flat_map(|r| &r.verdicts).filter(|v| self.shows(v)).count()
    }
}

/// One aligned line per verdict: the run, the metric, measured, wanted, their distance and what was allowed. Empty when
/// there is nothing to show; then and else a last line says how many held, if any were asked.
pub fn verdicts(rows: &[SummaryRow], shown: Shown) -> String {
    let all: Vec<&Verdict> = rows.iter().flat_map(|r| &r.verdicts).collect();
    if all.is_empty() {
        return String::new();
    }
    let header = ["scenario", "parameters", "metric", "measured", "wanted", "error", "relative", "allowed", "held"];
    let mut lines = vec![header.map(String::from).to_vec()];
    for row in rows {
        // The run is named once.
        let mut name = (clip(&row.scenario), brief_parameters(row, |_| true));
        for verdict in row.verdicts.iter().filter(|v| shown.shows(v)) {
            let (scenario, parameters) = std::mem::take(&mut name);
            lines.push(cells(scenario, parameters, verdict));
        }
    }
    let mut out = if lines.len() > 1 { align(&lines, 3) } else { String::new() };
    let (held, hidden) = (all.iter().filter(|v| v.held).count(), all.len() - (lines.len() - 1));
    let hint = if hidden > 0 { format!("; {hidden} not shown here, see --verdicts") } else { String::new() };
    // A String takes every write.
    let _ = writeln!(out, "{held} of {} expectations held{hint}", all.len());
    out
}

fn cells(scenario: String, parameters: String, verdict: &Verdict) -> Vec<String> {
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:?}"));
    let short = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.2e}"));
    let wanted = match (verdict.truth, verdict.min, verdict.max) {
        (Some(_), ..) => number(verdict.truth),
        (None, Some(min), Some(max)) => format!("{min:?}..{max:?}"),
        (None, Some(min), None) => format!(">= {min:?}"),
        (None, None, Some(max)) => format!("<= {max:?}"),
        (None, None, None) => "-".to_owned(),
    };
    let truth = verdict.truth.filter(|t| *t != 0.0);
    vec![
        scenario,
        parameters,
        verdict.metric.clone(),
        number(verdict.measured),
        wanted,
        short(verdict.error),
        short(verdict.error.and_then(|e| Some((e / truth?).abs()))),
        short(verdict.allowed),
        if verdict.held { "yes".into() } else { "NO".into() },
    ]
}

/// The swept values that are wanted, by the last word of their names, unless two share it; of a path its end alone. Swept
/// truths stand in a column of their own.
pub(crate) fn brief_parameters(row: &SummaryRow, wanted: impl Fn(&str) -> bool) -> String {
    // `rpy.1` of `floor.rpy.1`, `force` of `force.0.force`.
    let last = |name: &str| {
        let word = |i: usize| !name[i + 1..].starts_with(|d: char| d.is_ascii_digit());
        let dot = name.char_indices().rev().find(|&(i, c)| c == '.' && word(i));
        name[dot.map_or(0, |(i, _)| i + 1)..].to_owned()
    };
    let named: Vec<_> = row.parameters.iter().filter(|(name, _)| !is_truth(name) && wanted(name)).collect();
    let short = |name: &str| {
        let alone = named.iter().filter(|(other, _)| last(other) == last(name)).count() == 1;
        if alone { last(name) } else { name.to_owned() }
    };
    // A robot by the name of its file.
    let brief = |value: &ParamValue| {
        let text = value.to_string();
        let is_file = [".toml", ".urdf"].iter().any(|end| text.ends_with(end));
        text.rsplit('/').next().filter(|_| is_file).map_or(text.clone(), str::to_owned)
    };
    let text =
        named.iter().map(|(name, value)| format!("{}={}", short(name), brief(value))).collect::<Vec<_>>().join(" ");
    let text = visible(&text).into_owned();
    if text.chars().count() <= WIDEST { text } else { text.chars().take(WIDEST - 1).chain(['…']).collect() }
}
