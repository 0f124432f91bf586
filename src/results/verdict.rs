//! Verdicts: what was expected of a run, what was measured, and how far apart they are.

use crate::metrics::number;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
