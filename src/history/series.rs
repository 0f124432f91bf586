//! The last values of each run and metric in a history, and trends of them.
//!
//! A trend is shown by the rank test at a level that is divided by the number of tested series, so that
//! without any trend the probability of one is at most the level. A series with a trend must also have
//! changed by more than its tolerance from its first value to its last: for simulated values, which have
//! no noise, ranks alone would report rounding errors. For times a trend is one towards slower runs.

use std::collections::{HashMap, VecDeque};

use serde::Serialize;

use crate::compare::{ColumnCheck, Limits, Results, ResultsError, RunDigest, identity, is_measured};
use crate::history::History;
use crate::metrics::number;
use crate::statistics::{RankTrend, rank_trend};

/// Greatest number of series that are listed without a change or trend.
const MAX_SERIES: usize = 100_000;

/// Values of a run's metric over the results of a history, with the compared one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series {
    /// The run.
    pub run: String,
    /// The metric.
    pub column: String,
    /// Value in the compared result; none if it was not measured.
    #[serde(with = "number::some_real")]
    pub value: Option<f64>,
    /// Newest value of the history.
    #[serde(with = "number::real")]
    pub last: f64,
    /// Median of the values of the history.
    #[serde(with = "number::real")]
    pub median: f64,
    /// Greatest of them less the least.
    #[serde(with = "number::real")]
    pub spread: f64,
    /// Number of them.
    pub values: usize,
    /// True if the value is further from the last one than the tolerance.
    pub is_changed: bool,
    /// The test of a trend up to the compared value; none without that value.
    pub trend: Option<Trend>,
}

/// Test of a trend.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trend {
    /// Rising pairs less falling pairs of values.
    pub s: i64,
    /// Two-sided probability of such an `s` in a random order.
    pub p: f64,
    /// True if it is a trend at the level.
    pub is_shown: bool,
}

/// Comparison of a result with the last values of a history.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HistoryChanges {
    /// Results in the history, without the compared one.
    pub results: usize,
    /// Greatest number of values per series: the newest ones.
    pub last: usize,
    /// Probability of a trend where there is none.
    pub level: f64,
    /// Series whose values are equal; they are not listed.
    pub constant: usize,
    /// Series that were tested for a trend.
    pub tested: usize,
    /// Trends.
    pub trends: usize,
    /// Series with different values, in the order of runs and columns.
    pub series: Vec<Series>,
    /// Series without change and trend that the list leaves out, since it is long.
    pub omitted: usize,
}

/// Compares a result with the last `last` values of each run and metric, without the result with
/// the digest `except`. Trends are tested at the level `level`.
///
/// # Errors
/// A row cannot be read.
pub(super) fn history_changes(
    (history, except): (&History, &str),
    results: &mut Results,
    limits: &Limits,
    (last, level): (usize, f64),
) -> Result<HistoryChanges, ResultsError> {
    let entries = || history.entries.iter().filter(|entry| entry.result != except);
    let mut found = HistoryChanges { results: entries().count(), last, level, ..HistoryChanges::default() };
    let mut rows_of: HashMap<(RunDigest, usize), VecDeque<usize>> = HashMap::new();
    for row in entries().flat_map(|entry| entry.rows.clone()) {
        rows_of.entry(history.runs[row].identity).or_default().push_back(row);
    }
    let compared: Vec<(usize, Option<usize>, ColumnCheck)> = history
        .metrics
        .iter()
        .enumerate()
        .filter(|(_, (name, _))| is_measured(name))
        .filter_map(|(index, (name, _))| Some((index, results.position(name), limits.check_of(name)?)))
        .collect();
    let mut equal: HashMap<RunDigest, usize> = HashMap::new();
    let mut row = results.blank_row();
    for position in 0..results.len() {
        results.read(position, &mut row)?;
        let run = identity(&row);
        let count = equal.entry(run).or_default();
        let own = rows_of.get(&(run, *count));
        *count += 1;
        let Some(own) = own else { continue };
        for (metric, at, check) in &compared {
            let (name, values) = &history.metrics[*metric];
            let before = own.iter().rev().filter_map(|row| values.get(*row)).filter(|value| !value.is_nan());
            let mut before: Vec<f64> = before.take(last).collect();
            before.reverse();
            let value = at.and_then(|at| row.cell(at).parse().ok()).filter(|value: &f64| !value.is_nan());
            if let Some(series) = series(before, value, *check) {
                found.add(Series { run: String::new(), column: name.clone(), ..series }, || row.label());
            } else {
                found.constant += usize::from(own.iter().any(|row| values.get(*row).is_some()));
            }
        }
    }
    found.decide();
    Ok(found)
}

/// The statistics of a series; none if all values are equal or the history has none.
fn series(before: Vec<f64>, value: Option<f64>, check: ColumnCheck) -> Option<Series> {
    let (&first, &last) = (before.first()?, before.last()?);
    let mut sorted = before.clone();
    sorted.sort_by(f64::total_cmp);
    let (n, least, greatest) = (sorted.len(), sorted[0], sorted[sorted.len() - 1]);
    if least == greatest && value == Some(least) {
        return None;
    }
    let spread = if least == greatest { 0.0 } else { greatest - least };
    let (low, high) = (sorted[(n - 1) / 2], sorted[n / 2]);
    // Halves, since the sum of two numbers may overflow.
    let median = if low == high { low } else { low / 2.0 + high / 2.0 };
    let is_beyond = |from: f64| match value {
        Some(value) => check.difference_of(from, value).is_some_and(|difference| difference.beyond),
        None => true,
    };
    let trend = value.and_then(|value| {
        let RankTrend { s, p } = rank_trend(&[before.as_slice(), &[value]].concat())?;
        let may_show = match check {
            ColumnCheck::Number(_) => is_beyond(first),
            // Faster runs are no regression.
            ColumnCheck::Time { inverse, .. } => (s > 0) != inverse,
        };
        Some(Trend { s, p, is_shown: may_show })
    });
    let (run, column) = Default::default();
    Some(Series { run, column, value, last, median, spread, values: n, is_changed: is_beyond(last), trend })
}

impl HistoryChanges {
    fn add(&mut self, series: Series, run: impl FnOnce() -> String) {
        self.tested += usize::from(series.trend.is_some());
        let is_candidate = series.trend.is_some_and(|trend| trend.is_shown && trend.p <= self.level);
        if is_candidate || series.is_changed || self.series.len() < MAX_SERIES {
            self.series.push(Series { run: run(), ..series });
        } else {
            self.omitted += 1;
        }
    }

    /// Decides on trends, once the number of tests is known.
    fn decide(&mut self) {
        let level = self.level / self.tested.max(1) as f64;
        for trend in self.series.iter_mut().filter_map(|series| series.trend.as_mut()) {
            trend.is_shown &= trend.p <= level;
            self.trends += usize::from(trend.is_shown);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Tolerance;

    const NUMBER: ColumnCheck = ColumnCheck::Number(Tolerance { absolute: 0.5, relative: 0.0 });

    #[test]
    fn statistics_have_their_closed_forms() {
        let found = series(vec![3.0, 1.0, 2.0, 10.0], Some(10.4), NUMBER).unwrap();
        assert_eq!((found.last, found.median, found.spread, found.values), (10.0, 2.5, 9.0, 4));
        assert!(!found.is_changed, "within the tolerance of the last value");
        assert!(series(vec![3.0, 1.0], Some(1.6), NUMBER).unwrap().is_changed);
        assert_eq!(series(vec![2.0, 2.0], Some(2.0), NUMBER), None);
        assert_eq!(series(vec![], Some(2.0), NUMBER), None);
        let unmeasured = series(vec![2.0, 2.0], None, NUMBER).unwrap();
        assert!(unmeasured.is_changed && unmeasured.trend.is_none());
        let infinite = series(vec![f64::INFINITY, f64::INFINITY], Some(1.0), NUMBER).unwrap();
        assert_eq!((infinite.median, infinite.spread, infinite.is_changed), (f64::INFINITY, 0.0, true));
        assert_eq!(series(vec![f64::MAX, f64::MAX, -1.0], Some(0.0), NUMBER).unwrap().median, f64::MAX);
    }

    #[test]
    fn a_drift_of_small_steps_is_a_trend_only_beyond_the_tolerance() {
        let rising = |step: f64, check| {
            let values: Vec<f64> = (0..10).map(|i| f64::from(i) * step).collect();
            let mut found = HistoryChanges { level: 0.01, ..HistoryChanges::default() };
            found.add(series(values, Some(10.0 * step), check).unwrap(), String::new);
            found.decide();
            (found.series[0].is_changed, found.trends)
        };
        assert_eq!(rising(0.1, NUMBER), (false, 1), "each step is within the tolerance, all are not");
        assert_eq!(rising(0.04, NUMBER), (false, 0));
        assert_eq!(rising(0.1, ColumnCheck::Time { ratio: 2.0, inverse: false }), (false, 1));
        assert_eq!(rising(-0.1, ColumnCheck::Time { ratio: 2.0, inverse: false }).1, 0, "faster");
        assert_eq!(rising(-0.1, ColumnCheck::Time { ratio: 2.0, inverse: true }).1, 1);
    }

    #[test]
    fn the_level_is_that_of_all_tests_together() {
        // Six rising values: 2 / 6! = 0.0028.
        let add = |others: usize| {
            let mut found = HistoryChanges { level: 0.01, ..HistoryChanges::default() };
            found.add(series(vec![0.0, 1.0, 2.0, 3.0, 4.0], Some(5.0), NUMBER).unwrap(), String::new);
            for _ in 0..others {
                found.add(series(vec![0.0, 1.0], Some(0.0), NUMBER).unwrap(), String::new);
            }
            found.decide();
            (found.tested, found.trends)
        };
        assert_eq!([add(0), add(2), add(3)], [(1, 1), (3, 1), (4, 0)]);
    }
}
