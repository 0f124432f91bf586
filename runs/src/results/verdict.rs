//! Verdicts: expected and measured values of a run, and their distance.

use crate::metrics::number;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The result of one expectation in a run. Numbers are in the metric's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// A numeric column of the summary, or `outcome`.
    pub metric: String,
    /// Measured value; none for an outcome, and for an event that did not occur.
    #[serde(with = "number::some_real")]
    #[schemars(with = "crate::results::Measure")]
    pub measured: Option<f64>,
    /// Expected value; none where there are only limits.
    pub truth: Option<f64>,
    /// Largest allowed distance from `truth`.
    pub allowed: Option<f64>,
    /// Smallest allowed value.
    pub min: Option<f64>,
    /// Largest allowed value.
    pub max: Option<f64>,
    /// Measured minus expected value; with limits, the distance beyond them, 0 between them.
    #[serde(with = "number::some_real")]
    #[schemars(with = "crate::results::Measure")]
    pub error: Option<f64>,
    /// True if the expectation held.
    pub held: bool,
    /// Reason of a failure; may be empty.
    pub message: String,
}
