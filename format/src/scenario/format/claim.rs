//! `[[claim]]`: statements about all runs of a sweep.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::metrics::METRICS;
use crate::scenario::format::expect::{Expect, metric};
use crate::text::quantity::json;

/// One claim: about a `share` of the runs, a `quantile` of a `metric`, the `difference` of a metric
/// `between` two values of a swept key, or its `change` against earlier results; with `at_least` or
/// `at_most`. It holds, fails, or is undecided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(extend("required" = ["name"]))]
pub struct ClaimSpec {
    /// Name of the claim, unique in the file.
    pub name: String,
    /// The claim is about the share of runs for which this holds: an outcome, or limits of a
    /// metric, as in `expect`; with `change`, limits of the change, without `metric`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<Expect>,
    /// The claim is about this quantile of `metric`, between 0 and 1; with `difference` or `change`,
    /// about the quantile of the differences, by default their median, 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Fraction>")]
    pub quantile: Option<f64>,
    /// A numeric column of the summary, for `quantile`.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "metric")]
    #[schemars(extend("anyOf" = [{ "enum": METRICS }, { "pattern": "^error_" }]))]
    pub metric: Option<String>,
    /// The claim is about paired differences of this numeric column of the summary: its value with
    /// the first value of `between` less that with the second.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "metric")]
    #[schemars(extend("anyOf" = [{ "enum": METRICS }, { "pattern": "^error_" }]))]
    pub difference: Option<String>,
    /// A swept key with two of its values. Two runs are a pair if they are equal but for this key,
    /// and the keys of the same table of `zip` or `list`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, [serde_json::Value; 2]>")]
    pub between: BTreeMap<String, Vec<toml::Value>>,
    /// The claim is about changes of this numeric column of the summary: its value less that of the
    /// same run in a baseline. `runner compare --baseline` judges it.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "metric")]
    #[schemars(extend("anyOf" = [{ "enum": METRICS }, { "pattern": "^error_" }]))]
    pub change: Option<String>,
    /// The share, quantile or difference is this or greater. A share is between 0 and 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// The share, quantile or difference is this or less.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// One less the greatest probability with which the claim holds although it is false, or fails
    /// although it is true.
    #[schemars(with = "json::Fraction")]
    pub confidence: f64,
    /// True judges the claim after each run, in the order of the runs, and starts no further runs
    /// once it is decided. That needs wider bounds, which allow for the repeated tests.
    pub early: bool,
    /// Swept keys: the claim is judged for each of their values alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub per: Vec<String>,
}

impl Default for ClaimSpec {
    fn default() -> Self {
        ClaimSpec {
            name: String::new(),
            share: None,
            quantile: None,
            metric: None,
            difference: None,
            between: BTreeMap::new(),
            change: None,
            at_least: None,
            at_most: None,
            confidence: 0.95,
            early: false,
            per: Vec::new(),
        }
    }
}

/// A claim as a statement about a share: that of the runs which fulfil a condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShareQuestion {
    /// Threshold of the share, between 0 and 1.
    pub threshold: f64,
    /// True if the claim is that the share is at least the threshold, false for at most.
    pub at_least: bool,
}

impl ClaimSpec {
    /// The quantile that it is about; none for a share.
    pub fn quantile(&self) -> Option<f64> {
        let is_difference = self.difference.is_some() || self.change.is_some();
        if is_difference && self.share.is_none() { Some(self.quantile.unwrap_or(0.5)) } else { self.quantile }
    }

    /// The column that it is about; none for outcomes.
    pub fn column(&self) -> Option<&str> {
        let of_share = || self.share.as_ref().and_then(|share| share.metric.as_deref());
        self.difference.as_deref().or(self.change.as_deref()).or(self.metric.as_deref()).or_else(of_share)
    }

    /// The limit, of a share or in the metric's unit.
    pub fn limit(&self) -> f64 {
        self.at_least.or(self.at_most).unwrap_or(0.0)
    }

    /// The equivalent statement about a share. A quantile is at most a limit exactly if the share
    /// of values up to the limit is at least the quantile, and at least a limit exactly if the
    /// share of values below it is at most the quantile.
    pub fn question(&self) -> ShareQuestion {
        match self.quantile() {
            Some(quantile) => ShareQuestion { threshold: quantile, at_least: self.at_most.is_some() },
            None => ShareQuestion { threshold: self.limit(), at_least: self.at_least.is_some() },
        }
    }

    /// Whether a value of the column counts for the share of [`ClaimSpec::question`].
    pub fn counts(&self, value: f64) -> bool {
        if self.at_most.is_some() { value <= self.limit() } else { value < self.limit() }
    }

    /// Such as `share of runs with outcome passed at least 0.9`.
    pub fn statement(&self) -> String {
        let relation = if self.at_least.is_some() { "at least" } else { "at most" };
        let which = |quantile: Option<f64>| match quantile {
            Some(quantile) if quantile != 0.5 => format!("{quantile} quantile"),
            _ => "median".to_owned(),
        };
        if let Some(column) = &self.change {
            let subject = match &self.share {
                Some(share) => format!("share of changes of {column} against the baseline {}", share.limits()),
                None => format!("{} of the change of {column} against the baseline", which(self.quantile())),
            };
            return format!("{subject} {relation} {}", self.limit());
        }
        let subject = match (&self.share, &self.difference, &self.metric) {
            (Some(share), ..) => format!("share of runs with {}", share.condition()),
            (None, Some(column), _) => {
                let (key, values) = self.between.first_key_value().map_or(("", &[][..]), |(k, v)| (k, v));
                let texts: Vec<String> = values.iter().map(value_text).collect();
                let subject = which(self.quantile());
                format!("{subject} of the difference of {column} between {key} = {}", texts.join(" and "))
            }
            (None, None, metric) => {
                let quantile = self.quantile.unwrap_or(0.5);
                format!("{quantile} quantile of {}", metric.as_deref().unwrap_or("?"))
            }
        };
        format!("{subject} {relation} {}", self.limit())
    }
}

/// A swept value without the quotes of a text.
pub fn value_text(value: &toml::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
