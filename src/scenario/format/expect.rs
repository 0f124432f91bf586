//! `[[expect]]`: verdicts about a run.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::metrics::METRICS;
use crate::scenario::quantity::{json, some_non_negative};
use crate::text::suggest;

/// One expectation: a metric with `value` and `tolerance` or `relative_tolerance`, or with `min`, `max` or both; or an outcome.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Expect {
    /// A numeric column of the summary; `error_METRIC` where `compare.truth` has that metric.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "metric")]
    #[schemars(extend("anyOf" = [{ "enum": METRICS }, { "pattern": "^error_" }]))]
    pub metric: Option<String>,
    /// Wanted value, in the metric's unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Greatest distance from `value`.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub tolerance: Option<f64>,
    /// Greatest distance from `value` as a fraction of it; added to `tolerance` where both are given.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub relative_tolerance: Option<f64>,
    /// Smallest value allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Greatest value allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// How the run must end, instead of a metric.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outcome: Option<ExpectedOutcome>,
}

/// How a run must end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExpectedOutcome {
    /// At its end.
    Passed,
    /// By a stop rule.
    Fallen,
    /// By numbers out of range.
    Diverged,
    /// By too many events in too little time.
    Stalled,
    /// By the wall clock.
    TimedOut,
    /// By an error.
    Error,
}

impl ExpectedOutcome {
    /// The word in the summary.
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

fn metric<'de, D: Deserializer<'de>>(d: D) -> Result<Option<String>, D::Error> {
    let name = String::deserialize(d)?;
    let distance = name.strip_prefix("error_").is_some_and(|of| METRICS.contains(&of));
    if METRICS.contains(&name.as_str()) || distance {
        return Ok(Some(name));
    }
    let help = suggest::help(&name, METRICS.iter().copied());
    Err(D::Error::custom(format!("names no numeric column of the summary: `{name}`\n{help}")))
}

impl Expect {
    /// Greatest distance from `value` that holds; none without a value.
    pub fn allowed(&self) -> Option<f64> {
        let relative = self.relative_tolerance.unwrap_or(0.0);
        self.value.map(|wanted| self.tolerance.unwrap_or(0.0) + relative * wanted.abs())
    }

    /// How far a measured value is off: from the wanted value, or beyond the limits (0 between them).
    pub fn error(&self, measured: f64) -> f64 {
        match (self.value, self.min, self.max) {
            (Some(wanted), ..) => measured - wanted,
            (None, Some(min), _) if measured < min => measured - min,
            (None, _, Some(max)) if measured > max => measured - max,
            _ if measured.is_nan() => f64::NAN,
            _ => 0.0,
        }
    }

    /// Does the metric's value hold? `Err` says in words why not. A value that is not a number never holds.
    pub fn check(&self, value: f64) -> Result<(), String> {
        let name = self.metric.as_deref().unwrap_or("value");
        if value.is_nan() {
            return Err(format!("{name} is not a number"));
        }
        if let Some(wanted) = self.value {
            let tolerance = self.allowed().unwrap_or(0.0);
            let distance = (value - wanted).abs();
            if distance > tolerance {
                return Err(format!("{name} is {value}, {distance:e} from {wanted} (tolerance {tolerance:e})"));
            }
        }
        if let Some(min) = self.min
            && value < min
        {
            return Err(format!("{name} is {value}, below {min}"));
        }
        if let Some(max) = self.max
            && value > max
        {
            return Err(format!("{name} is {value}, above {max}"));
        }
        Ok(())
    }

    /// Judge a run by the word for how it ended and a look-up of its metrics; `Err` says in words what did not hold.
    /// A metric that the run did not measure, such as the time of a slip that never came, does not hold.
    pub fn judge(&self, outcome: &str, metric: impl Fn(&str) -> Option<f64>) -> Result<(), String> {
        if let Some(wanted) = self.outcome
            && wanted.name() != outcome
        {
            return Err(format!("outcome is {outcome}, not {}", wanted.name()));
        }
        match &self.metric {
            Some(name) => self.check(metric(name).ok_or_else(|| format!("{name} has no value"))?),
            None => Ok(()),
        }
    }
}
