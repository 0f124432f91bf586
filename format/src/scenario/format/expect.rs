//! `[[expect]]`: expectations by which a run is judged.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::metrics::METRICS;
use crate::text::quantity::{json, some_non_negative};
use crate::text::suggest;

/// One expectation: a metric with `value` and `tolerance` or `relative_tolerance`, or with `min`,
/// `max` or both; or an outcome.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Expect {
    /// A numeric column of the summary; `error_METRIC` where `compare.truth` has that metric.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "metric")]
    #[schemars(extend("anyOf" = [{ "enum": METRICS }, { "pattern": "^error_" }]))]
    pub metric: Option<String>,
    /// Expected value, in the metric's unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Greatest distance from `value`.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub tolerance: Option<f64>,
    /// Greatest distance from `value` as a fraction of it; added to `tolerance` where both are
    /// given.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub relative_tolerance: Option<f64>,
    /// Smallest value allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Greatest value allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Required outcome of the run, instead of a metric.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outcome: Option<ExpectedOutcome>,
}

/// Required outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExpectedOutcome {
    /// The run reached its end.
    Passed,
    /// A stop rule ended it.
    Fallen,
    /// Numbers went out of range.
    Diverged,
    /// Too many events happened in too short a time.
    Stalled,
    /// The limit of wall-clock time was reached.
    TimedOut,
    /// An error ended it.
    Error,
}

impl ExpectedOutcome {
    /// Its name in the summary.
    pub fn name(self) -> &'static str {
        match self {
            ExpectedOutcome::Passed => "passed",
            ExpectedOutcome::Fallen => "fallen",
            ExpectedOutcome::Diverged => "diverged",
            ExpectedOutcome::Stalled => "stalled",
            ExpectedOutcome::TimedOut => "timed-out",
            ExpectedOutcome::Error => "error",
        }
    }
}

/// A numeric column of the summary.
pub(in crate::scenario::format) fn metric<'de, D: Deserializer<'de>>(d: D) -> Result<Option<String>, D::Error> {
    let name = String::deserialize(d)?;
    let is_error = name.strip_prefix("error_").is_some_and(|of| METRICS.contains(&of));
    if METRICS.contains(&name.as_str()) || is_error {
        return Ok(Some(name));
    }
    let help = suggest::help(&name, METRICS.iter().copied());
    Err(D::Error::custom(format!("names no numeric column of the summary: `{name}`\n{help}")))
}

impl Expect {
    /// What it requires, such as `outcome passed`, `impacts at most 3`.
    pub fn condition(&self) -> String {
        match self.outcome {
            Some(outcome) => format!("outcome {}", outcome.name()),
            None => format!("{} {}", self.metric.as_deref().unwrap_or("value"), self.limits()),
        }
    }

    /// The limits of its metric, such as `at most 3`.
    pub fn limits(&self) -> String {
        match (self.allowed(), self.min, self.max) {
            (Some(allowed), ..) => format!("within {allowed} of {}", self.value.unwrap_or(0.0)),
            (None, Some(min), Some(max)) => format!("from {min} to {max}"),
            (None, Some(min), None) => format!("at least {min}"),
            (None, None, max) => format!("at most {}", max.unwrap_or(0.0)),
        }
    }

    /// Greatest allowed distance from `value`; none without a value.
    pub fn allowed(&self) -> Option<f64> {
        let relative = self.relative_tolerance.unwrap_or(0.0);
        self.value.map(|expected| self.tolerance.unwrap_or(0.0) + relative * expected.abs())
    }

    /// Deviation of a measured value from the expected one, or beyond the limits (0 between them).
    pub fn error(&self, measured: f64) -> f64 {
        match (self.value, self.min, self.max) {
            (Some(expected), ..) => measured - expected,
            (None, Some(min), _) if measured < min => measured - min,
            (None, _, Some(max)) if measured > max => measured - max,
            _ if measured.is_nan() => f64::NAN,
            _ => 0.0,
        }
    }

    /// Checks a metric's value. NaN never holds.
    ///
    /// # Errors
    /// How the value violates the expectation.
    pub fn check(&self, value: f64) -> Result<(), Violation> {
        let name = || self.metric.clone().unwrap_or_else(|| "value".into());
        if value.is_nan() {
            return Err(Violation::NotANumber { metric: name() });
        }
        if let Some(expected) = self.value {
            let tolerance = self.allowed().unwrap_or(0.0);
            let distance = (value - expected).abs();
            if distance > tolerance {
                return Err(Violation::OffValue { metric: name(), value, distance, expected, tolerance });
            }
        }
        if let Some(min) = self.min
            && value < min
        {
            return Err(Violation::Below { metric: name(), value, min });
        }
        if let Some(max) = self.max
            && value > max
        {
            return Err(Violation::Above { metric: name(), value, max });
        }
        Ok(())
    }

    /// Judges a run by the name of its outcome and a look-up of its metrics. A metric that the run
    /// did not measure, such as the time of a slip that never came, does not hold.
    ///
    /// # Errors
    /// The violation of the expectation.
    pub fn judge(&self, outcome: &str, metric: impl Fn(&str) -> Option<f64>) -> Result<(), Violation> {
        if let Some(expected) = self.outcome
            && expected.name() != outcome
        {
            return Err(Violation::Outcome { outcome: outcome.to_owned(), expected: expected.name() });
        }
        match &self.metric {
            Some(name) => self.check(metric(name).ok_or_else(|| Violation::Unmeasured { metric: name.clone() })?),
            None => Ok(()),
        }
    }
}

/// How a run violates an expectation.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[allow(missing_docs, reason = "each field is in the message")]
pub enum Violation {
    /// The run ended in another way.
    #[error("outcome is {outcome}, not {expected}")]
    Outcome { outcome: String, expected: &'static str },
    /// The run did not measure the metric.
    #[error("{metric} has no value")]
    Unmeasured { metric: String },
    /// The value is NaN.
    #[error("{metric} is not a number")]
    NotANumber { metric: String },
    /// The value is further from the expected one than the tolerance.
    #[error("{metric} is {value}, {distance:e} from {expected} (tolerance {tolerance:e})")]
    OffValue { metric: String, value: f64, distance: f64, expected: f64, tolerance: f64 },
    /// The value is below the lower limit.
    #[error("{metric} is {value}, below {min}")]
    Below { metric: String, value: f64, min: f64 },
    /// The value is above the upper limit.
    #[error("{metric} is {value}, above {max}")]
    Above { metric: String, value: f64, max: f64 },
}
