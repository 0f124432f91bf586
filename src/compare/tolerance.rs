//! Tolerances by column, and the check of two values against them.

use std::collections::{BTreeMap, BTreeSet};

use crate::compare::columns::is_measured;
use crate::compare::results::Results;

/// Allowed distance of two numbers: `absolute + relative max(|a|, |b|)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// In the column's unit.
    pub absolute: f64,
    /// As a fraction of the greater of the two.
    pub relative: f64,
}

/// Allowed differences.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// For columns without their own tolerance.
    pub default: Tolerance,
    /// By column.
    pub columns: BTreeMap<String, Tolerance>,
    /// Allowed ratio of B's times to A's; none: times are not compared.
    pub timing: Option<f64>,
}

impl Default for Limits {
    /// Differences in the last digits of a smooth run between compilers or processors: 1e-9 and
    /// 1e-6 of the value.
    fn default() -> Self {
        let default = Tolerance { absolute: 1e-9, relative: 1e-6 };
        Limits { default, columns: BTreeMap::new(), timing: None }
    }
}

/// A tolerance for an unknown column.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("neither result has a numeric column `{column}`: {help}")]
pub struct UnknownColumn {
    /// The name.
    pub column: String,
    /// A suggestion.
    pub help: String,
}

impl Limits {
    /// Checks that each named column is in one of the results.
    pub(super) fn check(&self, a: &Results, b: &Results) -> Result<(), UnknownColumn> {
        let names = a.columns().iter().chain(b.columns()).map(String::as_str);
        let known: BTreeSet<&str> = names.filter(|name| is_measured(name)).collect();
        match self.columns.keys().find(|column| !known.contains(column.as_str())) {
            Some(column) => {
                let help = crate::text::suggest(column, known);
                Err(UnknownColumn { column: column.clone(), help })
            }
            None => Ok(()),
        }
    }

    /// The check of a column; none when it is not compared.
    pub(crate) fn check_of(&self, column: &str) -> Option<ColumnCheck> {
        match (self.columns.get(column), crate::metrics::column(column).is_some_and(|c| c.is_cost())) {
            // An infinite tolerance ignores the column.
            (Some(tolerance), _) if tolerance.absolute.is_infinite() => None,
            (Some(tolerance), _) => Some(ColumnCheck::Number(*tolerance)),
            (None, true) => self.timing.map(|ratio| ColumnCheck::Time { ratio, inverse: column == "real_time_factor" }),
            (None, false) => Some(ColumnCheck::Number(self.default)),
        }
    }
}

/// Measured columns of both, in A's order, and those of one alone.
pub(super) fn common(a: &Results, b: &Results) -> (Vec<String>, Vec<String>) {
    let measured = |r: &Results| -> Vec<String> { r.columns().iter().filter(|c| is_measured(c)).cloned().collect() };
    let (in_a, in_b) = (measured(a), measured(b));
    let (common, mut alone): (Vec<_>, Vec<_>) = in_a.iter().cloned().partition(|c| in_b.contains(c));
    alone.extend(in_b.into_iter().filter(|c| !in_a.contains(c)));
    (common, alone)
}

/// Check of the values of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ColumnCheck {
    Number(Tolerance),
    /// B may be slower by this factor, and faster by any. `inverse`: the column decreases with
    /// time.
    Time {
        ratio: f64,
        inverse: bool,
    },
}

/// The difference of two cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellDifference {
    pub beyond: bool,
    pub distance: Option<f64>,
    pub relative: Option<f64>,
    pub allowed: f64,
}

impl From<Tolerance> for ColumnCheck {
    fn from(tolerance: Tolerance) -> Self {
        ColumnCheck::Number(tolerance)
    }
}

impl ColumnCheck {
    /// Checks two cells; none when they are equal.
    pub fn difference(self, a: &str, b: &str) -> Option<CellDifference> {
        if a == b {
            return None;
        }
        let (x, y) = match (number(a), number(b)) {
            (Some(x), Some(y)) => (x, y),
            // A run without times is not slower.
            _ if matches!(self, ColumnCheck::Time { .. }) => return None,
            _ => return Some(CellDifference { beyond: true, distance: None, relative: None, allowed: 0.0 }),
        };
        self.difference_of(x, y)
    }

    /// Checks two numbers; none when they are equal.
    pub fn difference_of(self, x: f64, y: f64) -> Option<CellDifference> {
        if x == y || x.is_nan() && y.is_nan() {
            return None;
        }
        let (distance, scale) = ((x - y).abs(), x.abs().max(y.abs()));
        let (within, allowed) = match self {
            ColumnCheck::Number(t) => {
                let allowed = t.absolute + t.relative * scale;
                (distance <= allowed, allowed)
            }
            ColumnCheck::Time { ratio, inverse: false } => (y <= ratio * x, ratio),
            ColumnCheck::Time { ratio, inverse: true } => (x <= ratio * y, ratio),
        };
        let finite = |value: f64| Some(value).filter(|v| v.is_finite());
        // An infinite value is beyond every tolerance of a finite one; a relative tolerance alone
        // would accept it.
        let beyond = !within || !distance.is_finite();
        Some(CellDifference { beyond, distance: finite(distance), relative: finite(distance / scale), allowed })
    }
}

fn number(cell: &str) -> Option<f64> {
    cell.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerance_is_the_sum_of_absolute_and_relative() {
        let kind = ColumnCheck::Number(Tolerance { absolute: 0.5, relative: 0.1 });
        let beyond = |a: &str, b: &str| kind.difference(a, b).map(|j| j.beyond);
        assert_eq!(beyond("10", "10.0"), None, "one number written in two ways");
        assert_eq!((beyond("10", "8.5"), beyond("8.5", "10")), (Some(false), Some(false)), "0.5 + 1");
        assert_eq!((beyond("10", "8.4"), beyond("-8.4", "-10")), (Some(true), Some(true)));
        assert_eq!((beyond("NaN", "NaN"), beyond("inf", "inf"), beyond("", "")), (None, None, None));
        for (a, b) in [("NaN", "1"), ("inf", "1"), ("inf", "-inf"), ("", "1"), ("1", "")] {
            assert_eq!((beyond(a, b), beyond(b, a)), (Some(true), Some(true)), "{a:?} {b:?}");
        }
        let judged = kind.difference("10", "8").unwrap();
        assert_eq!((judged.distance, judged.relative, judged.allowed), (Some(2.0), Some(0.2), 1.5));
    }

    #[test]
    fn only_slower_times_are_beyond_tolerance() {
        let time = ColumnCheck::Time { ratio: 1.5, inverse: false };
        let factor = ColumnCheck::Time { ratio: 1.5, inverse: true };
        let beyond = |kind: ColumnCheck, a: &str, b: &str| kind.difference(a, b).unwrap().beyond;
        assert!(!beyond(time, "1", "1.5") && beyond(time, "1", "1.51") && !beyond(time, "1", "0.1"));
        assert!(!beyond(factor, "3", "2") && beyond(factor, "3", "1.9") && !beyond(factor, "3", "30"));
        assert_eq!((time.difference("1", ""), time.difference("", "1")), (None, None), "one was not timed");
    }

    #[test]
    fn times_are_compared_on_request() {
        let mut limits = Limits::default();
        assert_eq!(
            (limits.check_of("wall_s"), limits.check_of("steps")),
            (None, Some(ColumnCheck::Number(limits.default)))
        );
        limits.timing = Some(2.0);
        assert_eq!(limits.check_of("timing_cpu_min_s"), Some(ColumnCheck::Time { ratio: 2.0, inverse: false }));
        assert_eq!(limits.check_of("real_time_factor"), Some(ColumnCheck::Time { ratio: 2.0, inverse: true }));
        let own = Tolerance { absolute: 1.0, relative: 0.0 };
        limits.columns.insert("wall_s".into(), own);
        assert_eq!(limits.check_of("wall_s"), Some(ColumnCheck::Number(own)));
        limits.columns.insert("steps".into(), Tolerance { absolute: f64::INFINITY, relative: 0.0 });
        assert_eq!(limits.check_of("steps"), None, "ignored");
    }
}
