//! `[search]`: the runs are chosen by the results of earlier ones.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::expect::{self, Expect};

/// A search over the values of some keys, for each combination of values of the sweep alone: for the
/// boundary of a condition, or the least or greatest value of a metric. Exactly one of `boundary`,
/// `minimize` and `maximize` must be given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(extend("required" = ["over"]))]
pub struct SearchSpec {
    /// A condition: an outcome, or limits of a metric, as in `expect`. The search finds where it begins
    /// or ceases to hold, over one key or two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boundary: Option<Expect>,
    /// A numeric column of the summary, whose least value is searched over up to six keys.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "expect::metric")]
    pub minimize: Option<String>,
    /// A numeric column of the summary, whose greatest value is searched over up to six keys.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "expect::metric")]
    pub maximize: Option<String>,
    /// The searched keys: dotted paths of numbers of this file, in quotes.
    pub over: BTreeMap<String, SearchedKey>,
    /// With one key of a boundary: number of further values, evenly spaced, that are run to find out
    /// whether the condition changes once only; with them both ends.
    pub check: u32,
    /// With one key of a boundary: swept keys along which a search begins near the boundary of the
    /// value before, which takes fewer runs. Such searches run one after the other, and in the same
    /// part of a batch.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub follow: Vec<String>,
    /// With two keys of a boundary: number of squares along each side, a power of two, across which
    /// the boundary is drawn; 32 if it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "u32", range(min = 4, max = 1024))]
    pub squares: Option<u32>,
    /// Greatest number of runs; required but for a boundary over one key.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "u32", range(min = 1))]
    pub runs: Option<u32>,
    /// With `minimize` or `maximize`: a condition that the chosen run must meet, as in `expect`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub require: Option<Expect>,
    /// With `minimize` or `maximize`: number of runs that are chosen at once; 4 + 3 ln n, rounded
    /// down, for n keys if it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "u32", range(min = 4))]
    pub population: Option<u32>,
    /// With `minimize` or `maximize`: seed of the random numbers by which runs are chosen.
    pub seed: u64,
}

/// Where a key is searched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SearchedKey {
    /// The values between which is searched, ends included, in the unit of the key.
    pub between: [f64; 2],
    /// Greatest distance of neighbouring values, in the unit of the key. All values are multiples of
    /// `between` divided into equal steps of at most this size. With `logarithmic` the greatest ratio of
    /// neighbouring values less one.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub tolerance: f64,
    /// True for values in equal ratios, for positive ends.
    #[serde(default)]
    pub logarithmic: bool,
}

impl SearchSpec {
    /// The metric whose least or greatest value is searched, and whether it is the greatest.
    pub fn objective(&self) -> Option<(&str, bool)> {
        let least = self.minimize.as_deref().map(|metric| (metric, false));
        least.or(self.maximize.as_deref().map(|metric| (metric, true)))
    }

    /// What is searched: the condition, or the metric.
    pub fn subject(&self) -> String {
        match (&self.boundary, self.objective()) {
            (Some(condition), _) => condition.condition(),
            (None, Some((metric, _))) => metric.to_owned(),
            (None, None) => String::new(),
        }
    }

    /// Number of squares along each side of a boundary over two keys.
    pub fn squares(&self) -> u64 {
        u64::from(self.squares.unwrap_or(32))
    }
}
