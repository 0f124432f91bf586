//! The result of a claim: verdict, estimate, bounds, and their history over the runs.
//!
//! Bounds of a quantile are order statistics: the least value up to which at least the share of the
//! quantile is shown to lie, and the greatest below which at most that share is shown to lie. They
//! hold for every distribution.

use crate::metrics::number;
use crate::results::claims::claim_head::ClaimHead;
use crate::statistics::{Rule, ShareTest};
use crate::text::text_table::significant;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Greatest number of points of a history.
const MAX_POINTS: usize = 200;

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(inline)]
pub enum Judgement {
    /// The runs show that it is true.
    Holds,
    /// The runs show that it is false.
    Fails,
    /// The runs show neither.
    Undecided,
}

impl Judgement {
    /// Its name in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Judgement::Holds => "holds",
            Judgement::Fails => "fails",
            Judgement::Undecided => "undecided",
        }
    }
}

/// The result of a claim. Limits, estimate and bounds of a quantile or difference are in the
/// metric's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClaimVerdict {
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the claim.
    pub claim: String,
    /// The values of `per` for which this is the result; empty without.
    pub group: String,
    /// The claim in words.
    pub statement: String,
    /// Whether it holds.
    pub verdict: Judgement,
    /// Share, quantile or quantile of the differences in the runs that count; null without such runs.
    #[serde(with = "number::some_real")]
    #[schemars(with = "crate::results::Measure")]
    pub estimate: Option<f64>,
    /// Lower bound of the true value at the confidence; null without one.
    #[serde(with = "number::some_real")]
    #[schemars(with = "crate::results::Measure")]
    pub lower: Option<f64>,
    /// Upper bound of the true value at the confidence; null without one.
    #[serde(with = "number::some_real")]
    #[schemars(with = "crate::results::Measure")]
    pub upper: Option<f64>,
    /// The limit of the claim.
    pub limit: f64,
    /// True for `at_least`, false for `at_most`.
    pub at_least: bool,
    /// Confidence of the verdict and of each bound.
    pub confidence: f64,
    /// True if it was judged after each run.
    pub early: bool,
    /// True if a unit is a pair of runs.
    pub paired: bool,
    /// Numeric column of the summary that it is about; null for outcomes. Earlier versions did not
    /// record it.
    #[serde(default)]
    pub metric: Option<String>,
    /// Units (runs or pairs) that count: the first ones of the plan.
    pub used: usize,
    /// Units planned.
    pub planned: usize,
    /// Units that count without a value, because a run did not end normally or did not measure it.
    pub without_value: usize,
    /// Threshold of the share in `trace`: that of the claim, or its quantile.
    pub threshold: f64,
    /// In `claims.json` alone: the share that the claim is about, over the units in the order of the plan: of runs as in the
    /// claim, or of values up to its limit (below it, with `at_least`).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trace: Vec<TracePoint>,
}

/// Share and bounds after some units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TracePoint {
    /// Number of units.
    pub units: usize,
    /// Share of them.
    pub share: f64,
    /// Lower bound of the true share.
    pub lower: f64,
    /// Upper bound of the true share.
    pub upper: f64,
}

/// The units of a claim that count.
pub(super) struct Counted {
    /// Value of each unit, and whether it counts for the share.
    pub units: Vec<(Option<f64>, bool)>,
    /// Number of planned units.
    pub planned: usize,
}

/// Judges a claim.
pub(super) fn verdict(head: &ClaimHead, label: &str, counted: Counted) -> ClaimVerdict {
    let claim = &head.claim;
    let rule = if claim.early { Rule::Sequential } else { Rule::Fixed };
    let test = ShareTest { rule, alpha: 1.0 - claim.confidence };
    let (question, n) = (claim.question(), counted.units.len());
    let k = counted.units.iter().filter(|(_, counts)| *counts).count();
    let (estimate, lower, upper) = match claim.quantile() {
        Some(quantile) => quantile_bounds(test, quantile, question.at_least, &counted.units),
        None if n == 0 => (None, Some(0.0), Some(1.0)),
        None => (Some(k as f64 / n as f64), Some(test.lower_bound(n, k)), Some(test.upper_bound(n, k))),
    };
    // The number of units of a fixed test is the planned one, so that missing ones are counted both ways.
    let (all, most) = if claim.early { (n, k) } else { (counted.planned, k + counted.planned - n) };
    let (above, below) = match all {
        0 => (false, false),
        _ => (test.shows_at_least(all, k, question.threshold), test.shows_at_most(all, most, question.threshold)),
    };
    let (shown, refuted) = if question.at_least { (above, below) } else { (below, above) };
    let judgement = match (shown, refuted) {
        (true, _) => Judgement::Holds,
        (false, true) => Judgement::Fails,
        (false, false) => Judgement::Undecided,
    };
    ClaimVerdict {
        scenario: head.scenario.clone(),
        claim: claim.name.clone(),
        group: label.to_owned(),
        statement: claim.statement(),
        verdict: judgement,
        estimate,
        lower,
        upper,
        limit: claim.limit(),
        at_least: claim.at_least.is_some(),
        confidence: claim.confidence,
        early: claim.early,
        paired: claim.difference.is_some() || claim.change.is_some(),
        metric: claim.column().map(str::to_owned),
        used: n,
        planned: counted.planned,
        without_value: counted.units.iter().filter(|(value, _)| value.is_none()).count(),
        threshold: question.threshold,
        trace: trace(test, &counted.units),
    }
}

/// Sample quantile with its bounds.
fn quantile_bounds(
    test: ShareTest,
    quantile: f64,
    at_most: bool,
    units: &[(Option<f64>, bool)],
) -> (Option<f64>, Option<f64>, Option<f64>) {
    // A unit without a value is beyond the limit.
    let missing = if at_most { f64::INFINITY } else { f64::NEG_INFINITY };
    let mut values: Vec<f64> = units.iter().map(|(value, _)| value.unwrap_or(missing)).collect();
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 {
        return (None, None, None);
    }
    // Less roundoff: 100 values have 55 up to the quantile 0.55, not 56.
    let rank = (n as f64 * quantile * (1.0 - 4.0 * f64::EPSILON)).ceil().clamp(1.0, n as f64) as usize;
    let counts: Vec<usize> = (0..=n).collect();
    let below = counts.partition_point(|k| test.shows_at_most(n, *k, quantile));
    let above = counts.partition_point(|k| !test.shows_at_least(n, *k, quantile));
    let lower = below.checked_sub(1).and_then(|k| values.get(k)).copied();
    let upper = above.checked_sub(1).filter(|_| above <= n).and_then(|k| values.get(k)).copied();
    (Some(values[rank - 1]), lower, upper)
}

/// Share and bounds after some of the units, the last included.
fn trace(test: ShareTest, units: &[(Option<f64>, bool)]) -> Vec<TracePoint> {
    let stride = units.len().div_ceil(MAX_POINTS).max(1);
    let mut points = Vec::new();
    let mut k = 0;
    for (i, (_, counts)) in units.iter().enumerate() {
        k += usize::from(*counts);
        let n = i + 1;
        if n % stride == 0 || n == units.len() {
            let share = k as f64 / n as f64;
            points.push(TracePoint { units: n, share, lower: test.lower_bound(n, k), upper: test.upper_bound(n, k) });
        }
    }
    points
}

impl ClaimVerdict {
    /// The claim's name, with the values of `per`.
    pub fn name(&self) -> String {
        if self.group.is_empty() { self.claim.clone() } else { format!("{} [{}]", self.claim, self.group) }
    }

    /// Such as `0.981 (0.962 to 0.993)`; a dash where a bound is missing.
    pub fn interval(&self) -> String {
        let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| significant(x, 3));
        format!("{} ({} to {})", number(self.estimate), number(self.lower), number(self.upper))
    }

    /// Such as `43 of 200 runs`.
    pub fn units(&self) -> String {
        format!("{} of {} {}", self.used, self.planned, if self.paired { "pairs" } else { "runs" })
    }

    /// The result in a line, without the name.
    pub fn summary(&self) -> String {
        let Self { verdict, statement, confidence, .. } = self;
        let without = match self.without_value {
            0 => String::new(),
            n => format!(", {n} without a value count against it"),
        };
        let percent = significant(100.0 * confidence, 6);
        let (name, interval, units) = (verdict.name(), self.interval(), self.units());
        format!("{name}: {statement}: {interval} at {percent} % confidence from {units}{without}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quantile_of_a_sample_is_the_least_value_with_its_share() {
        let units: Vec<(Option<f64>, bool)> = (1..=100).map(|value| (Some(f64::from(value)), true)).collect();
        for percent in 1..=99 {
            let quantile = f64::from(percent) / 100.0;
            let (found, ..) = quantile_bounds(ShareTest { rule: Rule::Fixed, alpha: 0.05 }, quantile, true, &units);
            assert_eq!(found, Some(f64::from(percent)), "{quantile}");
        }
    }
}
