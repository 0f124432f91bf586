//! Work and precision: error over cost.
//!
//! The cost of a run is processor seconds per simulated second; an error is any column `error_...`
//! of the summary. Runs of the same problem with different numerical methods are comparable: they
//! form a [`Group`]. The *Pareto front* of a group are the runs for which no other is both cheaper
//! and more accurate.
//!
//! Imports `results::{record, summary}`. `report` and the terminal output call it.

mod group;
mod table;

pub use group::{Curve, Group, groups};
pub use table::pareto_table;

use crate::metrics::NUMERIC_COLUMNS;
use crate::results::{SummaryRow, TruthError, metric};
use crate::sim::Outcome;

/// Cost and errors of one run.
#[derive(Clone, Debug)]
pub struct Work<'a> {
    /// The run.
    pub row: &'a SummaryRow,
    /// Processor seconds per simulated second; none when nothing was simulated.
    pub cost: Option<f64>,
    /// Simulated over wall-clock time; of the fastest repetition, if there were any.
    pub real_time_factor: f64,
    /// Columns `error_...` with a value. Only finite ones of finished runs are comparable.
    pub errors: Vec<(String, f64)>,
}

/// Why a run has no point in the diagram of cost and error.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotComparable {
    /// It did not reach its end.
    #[error("it ended as {}", .0.name())]
    Ended(Outcome),
    /// It has no value in this column.
    #[error("no error was measured")]
    NotMeasured,
    /// It or its reference ended early, at this time, s.
    #[error("it was compared up to {0} s only")]
    Until(f64),
    /// It took no time.
    #[error("it has no cost: nothing was simulated")]
    NoCost,
    /// Its error is infinite or not a number.
    #[error("the error is {0}")]
    NotFinite(f64),
}

impl<'a> Work<'a> {
    /// Cost and errors from a row of the summary.
    pub fn of(row: &'a SummaryRow) -> Self {
        // The shortest of repeated times has the least disturbance by other programs.
        let cost = row.repeats.map_or(row.cpu_s, |r| r.cpu_min_s) / row.metrics.duration_s;
        let fixed = NUMERIC_COLUMNS.iter().filter(|name| is_error(name)).map(|name| (*name).to_owned());
        let columns = fixed.chain(row.comparison.truth.iter().map(TruthError::column));
        Self {
            row,
            cost: (cost.is_finite() && cost > 0.0).then_some(cost),
            real_time_factor: row.repeats.map_or(row.real_time_factor, |r| row.metrics.duration_s / r.wall_min_s),
            errors: columns.filter_map(|name| metric(row, &name).map(|error| (name, error))).collect(),
        }
    }

    /// Cost and size of an error.
    ///
    /// # Errors
    /// The reason why this run is not comparable.
    pub fn point(&self, column: &str) -> Result<(f64, f64), NotComparable> {
        let comparison = &self.row.comparison;
        if !matches!(self.row.outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen) {
            return Err(NotComparable::Ended(self.row.outcome));
        }
        let Some((_, error)) = self.errors.iter().find(|(name, _)| name == column) else {
            return Err(NotComparable::NotMeasured);
        };
        let of_truth = comparison.truth.iter().any(|truth| truth.column() == column);
        if let (false, false, Some(until)) = (of_truth, comparison.whole, comparison.until_s) {
            return Err(NotComparable::Until(until));
        }
        match (self.cost, error.abs()) {
            (None, _) => Err(NotComparable::NoCost),
            (Some(_), error) if !error.is_finite() => Err(NotComparable::NotFinite(error)),
            (Some(cost), error) => Ok((cost, error)),
        }
    }
}

/// True if the column is a distance from a reference or truth; `energy_error_J` is a residual.
fn is_error(column: &str) -> bool {
    column.starts_with("error_")
}

/// Columns `error_...` with a value in any of the runs, in the order of first appearance.
pub fn error_columns(works: &[Work]) -> Vec<String> {
    let mut columns: Vec<String> = Vec::new();
    for (name, _) in works.iter().flat_map(|w| &w.errors) {
        if !columns.contains(name) {
            columns.push(name.clone());
        }
    }
    columns
}

/// The Pareto front of costs and errors rounded to three digits, the resolution of clocks and of
/// the tables.
pub fn front_as_shown(points: &[(f64, f64)]) -> Vec<bool> {
    let three = |x: f64| format!("{x:.2e}").parse().unwrap_or(x);
    front(&points.iter().map(|&(cost, error)| (three(cost), three(error))).collect::<Vec<_>>())
}

/// Which of the points (cost, error) are on the Pareto front: no other point is at most as costly
/// and at most as inaccurate, and better in one of the two. Points that are not finite are not on
/// it.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.retain(|&i| points[i].0.is_finite() && points[i].1.is_finite());
    order.sort_by(|&a, &b| points[a].partial_cmp(&points[b]).unwrap_or(std::cmp::Ordering::Equal));
    let mut on = vec![false; points.len()];
    let mut best: Option<(f64, f64)> = None;
    for i in order {
        // In the order of cost, a point of the front is more accurate than all before it, or equal
        // to the last one.
        if best.is_none_or(|b| points[i].1 < b.1 || points[i] == b) {
            on[i] = true;
            best = Some(points[i]);
        }
    }
    on
}
