//! Which columns are compared, and how far apart two values may be.

use std::collections::{BTreeMap, BTreeSet};

use crate::metrics::NUMERIC_COLUMNS;
use crate::results::changes::Results;

/// How far apart two numbers may be: `absolute + relative max(|a|, |b|)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// In the column's unit.
    pub absolute: f64,
    /// As a part of the greater of the two.
    pub relative: f64,
}

/// What is allowed to differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// For columns that are not named below.
    pub default: Tolerance,
    /// By column.
    pub columns: BTreeMap<String, Tolerance>,
    /// How many times as slow B may be as A; none: times are not compared.
    pub timing: Option<f64>,
}

impl Default for Limits {
    /// What another compiler or processor may change in the last digits of a smooth run: 1e-9 and 1e-6 of the value.
    fn default() -> Self {
        let default = Tolerance { absolute: 1e-9, relative: 1e-6 };
        Limits { default, columns: BTreeMap::new(), timing: None }
    }
}

/// Limits for a column that there is not.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("neither has a numeric column `{column}`: {help}")]
pub struct UnknownColumn {
    /// The name.
    pub column: String,
    /// What may be meant.
    pub help: String,
}

impl Limits {
    /// Is every column that is named in one of the results?
    pub(super) fn check(&self, a: &Results, b: &Results) -> Result<(), UnknownColumn> {
        let names = a.columns.iter().chain(&b.columns).map(String::as_str);
        let known: BTreeSet<&str> = names.filter(|name| is_measured(name)).collect();
        match self.columns.keys().find(|column| !known.contains(column.as_str())) {
            Some(column) => {
                let help = crate::text::suggest(column, known);
                Err(UnknownColumn { column: column.clone(), help })
            }
            None => Ok(()),
        }
    }

    /// How a column is compared; none when it is not.
    pub(super) fn kind(&self, column: &str) -> Option<Kind> {
        match (self.columns.get(column), crate::metrics::column(column).is_some_and(|c| c.is_cost())) {
            // Any distance is allowed, and any cell.
            (Some(tolerance), _) if tolerance.absolute.is_infinite() => None,
            (Some(tolerance), _) => Some(Kind::Number(*tolerance)),
            (None, true) => self.timing.map(|ratio| Kind::Time { ratio, inverse: column == "real_time_factor" }),
            (None, false) => Some(Kind::Number(self.default)),
        }
    }
}

/// Is it a measured number, and neither a swept parameter nor a word?
pub(super) fn is_measured(column: &str) -> bool {
    NUMERIC_COLUMNS.contains(&column) || column.strip_prefix("error_").is_some_and(|m| NUMERIC_COLUMNS.contains(&m))
}

/// Measured columns of both, in A's order, and those of one alone.
pub(super) fn common(a: &Results, b: &Results) -> (Vec<String>, Vec<String>) {
    let measured = |r: &Results| -> Vec<String> { r.columns.iter().filter(|c| is_measured(c)).cloned().collect() };
    let (in_a, in_b) = (measured(a), measured(b));
    let (common, mut alone): (Vec<_>, Vec<_>) = in_a.iter().cloned().partition(|c| in_b.contains(c));
    alone.extend(in_b.into_iter().filter(|c| !in_a.contains(c)));
    (common, alone)
}

/// How the values of a column are held against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Number(Tolerance),
    /// B may be slower by this factor; any faster is well. The inverse of a time is smaller when slower.
    Time {
        ratio: f64,
        inverse: bool,
    },
}

/// Two values that are not the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Judged {
    pub beyond: bool,
    pub distance: Option<f64>,
    pub relative: Option<f64>,
    pub allowed: f64,
}

impl Kind {
    /// Holds two cells against each other; none when they are the same.
    pub fn judge(self, a: &str, b: &str) -> Option<Judged> {
        let (x, y) = match (number(a), number(b)) {
            (Some(x), Some(y)) => (x, y),
            (None, None) if a == b => return None,
            // Who was not timed is not slow.
            _ if matches!(self, Kind::Time { .. }) => return None,
            _ => return Some(Judged { beyond: true, distance: None, relative: None, allowed: 0.0 }),
        };
        if x == y || x.is_nan() && y.is_nan() {
            return None;
        }
        let (distance, scale) = ((x - y).abs(), x.abs().max(y.abs()));
        let (within, allowed) = match self {
            Kind::Number(t) => {
                let allowed = t.absolute + t.relative * scale;
                (distance <= allowed, allowed)
            }
            Kind::Time { ratio, inverse: false } => (y <= ratio * x, ratio),
            Kind::Time { ratio, inverse: true } => (x <= ratio * y, ratio),
        };
        let finite = |value: f64| Some(value).filter(|v| v.is_finite());
        // One that is not finite beside one that is cannot be near it, whatever is allowed in proportion.
        let beyond = !within || !distance.is_finite();
        Some(Judged { beyond, distance: finite(distance), relative: finite(distance / scale), allowed })
    }
}

fn number(cell: &str) -> Option<f64> {
    cell.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_agree_within_both_tolerances_together() {
        let kind = Kind::Number(Tolerance { absolute: 0.5, relative: 0.1 });
        let beyond = |a: &str, b: &str| kind.judge(a, b).map(|j| j.beyond);
        assert_eq!(beyond("10", "10.0"), None, "one number in two writings");
        assert_eq!((beyond("10", "8.5"), beyond("8.5", "10")), (Some(false), Some(false)), "0.5 + 1");
        assert_eq!((beyond("10", "8.4"), beyond("-8.4", "-10")), (Some(true), Some(true)));
        assert_eq!((beyond("NaN", "NaN"), beyond("inf", "inf"), beyond("", "")), (None, None, None));
        for (a, b) in [("NaN", "1"), ("inf", "1"), ("inf", "-inf"), ("", "1"), ("1", "")] {
            assert_eq!((beyond(a, b), beyond(b, a)), (Some(true), Some(true)), "{a:?} {b:?}");
        }
        let judged = kind.judge("10", "8").unwrap();
        assert_eq!((judged.distance, judged.relative, judged.allowed), (Some(2.0), Some(0.2), 1.5));
    }

    #[test]
    fn only_slower_is_too_far_in_time() {
        let time = Kind::Time { ratio: 1.5, inverse: false };
        let factor = Kind::Time { ratio: 1.5, inverse: true };
        let beyond = |kind: Kind, a: &str, b: &str| kind.judge(a, b).unwrap().beyond;
        assert!(!beyond(time, "1", "1.5") && beyond(time, "1", "1.51") && !beyond(time, "1", "0.1"));
        assert!(!beyond(factor, "3", "2") && beyond(factor, "3", "1.9") && !beyond(factor, "3", "30"));
        assert_eq!((time.judge("1", ""), time.judge("", "1")), (None, None), "one was not timed");
    }

    #[test]
    fn times_are_compared_when_asked_for() {
        let mut limits = Limits::default();
        assert_eq!((limits.kind("wall_s"), limits.kind("steps")), (None, Some(Kind::Number(limits.default))));
        limits.timing = Some(2.0);
        assert_eq!(limits.kind("timing_cpu_min_s"), Some(Kind::Time { ratio: 2.0, inverse: false }));
        assert_eq!(limits.kind("real_time_factor"), Some(Kind::Time { ratio: 2.0, inverse: true }));
        let own = Tolerance { absolute: 1.0, relative: 0.0 };
        limits.columns.insert("wall_s".into(), own);
        assert_eq!(limits.kind("wall_s"), Some(Kind::Number(own)));
        limits.columns.insert("steps".into(), Tolerance { absolute: f64::INFINITY, relative: 0.0 });
        assert_eq!(limits.kind("steps"), None, "ignored");
    }
}
