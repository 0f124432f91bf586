//! A row of the summary: one run with the values of all columns. Column names are a contract with
//! users.

use crate::metrics::{Column, ColumnSource, Cost, Known, Measure, Metrics, column};
use crate::results::{Comparison, ParamValue, Repeats, Verdict};
use crate::sim::{AvoidanceTime, Outcome};

/// One run in the summary.
#[derive(Clone, Debug, PartialEq)]
pub struct SummaryRow {
    /// Name of the scenario.
    pub scenario: String,
    /// Key of the run.
    pub key: String,
    /// Outcome.
    pub outcome: Outcome,
    /// Reason of the outcome; may be empty.
    pub message: String,
    /// Contact method.
    pub method: String,
    /// Integrator.
    pub integrator: String,
    /// Seed.
    pub seed: u64,
    /// Swept parameters under their dotted names, in file order.
    pub parameters: Vec<(String, ParamValue)>,
    /// Expectations and their results; not a column.
    pub verdicts: Vec<Verdict>,
    /// Metrics.
    pub metrics: Metrics,
    /// Distances from the reference run and from known truths.
    pub comparison: Comparison,
    /// Wall-clock time, s.
    pub wall_s: f64,
    /// Processor time, s.
    pub cpu_s: f64,
    /// Simulated over wall-clock time.
    pub real_time_factor: f64,
    /// Times of repetitions, if there were any.
    pub repeats: Option<Repeats>,
    /// Processor time of self-collision avoidance; none without.
    pub avoidance: Option<AvoidanceTime>,
}

impl SummaryRow {
    /// True if an expectation did not hold, or the run did not finish and no expectation allows its
    /// outcome.
    pub fn is_refused(&self) -> bool {
        let expected = || !self.verdicts.is_empty() && self.verdicts.iter().all(|v| v.held);
        self.outcome == Outcome::Failed || !(matches!(self.outcome, Outcome::Passed | Outcome::Fallen) || expected())
    }
}

/// A column of text.
pub(in crate::results) struct TextColumn {
    pub name: &'static str,
    pub get: fn(&SummaryRow) -> &str,
}

/// Columns of text, which precede the swept parameters; `seed` follows them.
pub(in crate::results) const TEXT_COLUMNS: &[TextColumn] = &[
    TextColumn { name: "scenario", get: |r| &r.scenario },
    TextColumn { name: "key", get: |r| &r.key },
    TextColumn { name: "outcome", get: |r| r.outcome.name() },
    TextColumn { name: "message", get: |r| &r.message },
    TextColumn { name: "method", get: |r| &r.method },
    TextColumn { name: "integrator", get: |r| &r.integrator },
];

impl SummaryRow {
    /// The cell of a numeric column; nothing where the run could not measure it.
    pub fn cell(&self, column: &Column) -> Measure {
        if self.metrics.remote_robot && column.known == Known::Simulation {
            return Measure::Nothing;
        }
        match column.source {
            ColumnSource::Metrics(get) => get(&self.metrics, column.axis),
            ColumnSource::Cost(cost) => self.cost(cost).into(),
            ColumnSource::Distance(distance) => self.comparison.distance(distance).into(),
        }
    }

    fn cost(&self, cost: Cost) -> Option<f64> {
        match cost {
            Cost::Wall => Some(self.wall_s),
            Cost::Cpu => Some(self.cpu_s),
            Cost::RealTimeFactor => Some(self.real_time_factor),
            Cost::RepeatedWallMin => self.repeats.map(|t| t.wall_min_s),
            Cost::RepeatedWallMedian => self.repeats.map(|t| t.wall_median_s),
            Cost::RepeatedCpuMin => self.repeats.map(|t| t.cpu_min_s),
            Cost::RepeatedCpuMedian => self.repeats.map(|t| t.cpu_median_s),
            Cost::Avoidance => self.avoidance.map(|a| a.total_s),
            Cost::AvoidanceCycles => self.avoidance.map(|a| a.cycles_s),
        }
    }
}

/// The value of a numeric column, by its name in
/// [`NUMERIC_COLUMNS`](crate::metrics::NUMERIC_COLUMNS) or in [`truth_columns`]; none for another
/// name and for an empty cell (the first time of an event that never came).
pub fn metric(row: &SummaryRow, column: &str) -> Option<f64> {
    match measure(row, column) {
        Measure::Count(n) => Some(n as f64),
        Measure::Real(x) => Some(x),
        Measure::Nothing => None,
    }
}

/// The value of a numeric column, with counts as whole numbers.
pub fn measure(row: &SummaryRow, name: &str) -> Measure {
    match column(name) {
        Some(column) => row.cell(column),
        None => truth_error(row, name).into(),
    }
}

/// Names of the columns `error_METRIC`, the last of the summary: one for each metric with a known
/// truth, in the order of first appearance.
pub fn truth_columns(rows: &[SummaryRow]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for truth in rows.iter().flat_map(|r| &r.comparison.truth) {
        let name = truth.column();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The distance of a metric from its truth, by the name of its column.
pub(super) fn truth_error(row: &SummaryRow, column: &str) -> Option<f64> {
    let metric = column.strip_prefix("error_")?;
    row.comparison.truth.iter().find(|t| t.metric == metric)?.error
}
