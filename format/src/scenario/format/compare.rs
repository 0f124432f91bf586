//! `[compare]`: accuracy and cost of a run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::metrics::COLUMNS;
use crate::text::quantity::{json, some_count};
use crate::text::suggest;

/// Accuracy and cost of a run: against a reference run of the same cell, against known truths, by
/// repeated timing. At least one of the three is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompareSpec {
    /// Values of the reference run that differ, by dotted key; left out: no reference run.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<BTreeMap<String, serde_json::Value>>")]
    pub reference: Option<BTreeMap<String, toml::Value>>,
    /// True values of metrics, in their units.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, f64>", extend("propertyNames" = { "enum": truth_metrics() }))]
    pub truth: BTreeMap<TruthMetric, f64>,
    /// Number of timed repetitions of a run, alone on the machine; left out: none.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_count")]
    #[schemars(with = "Option<json::Count>")]
    pub timing_repeats: Option<u32>,
}

/// The name of a metric that may have a truth.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct TruthMetric(pub String);

impl<'de> Deserialize<'de> for TruthMetric {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let name = String::deserialize(d)?;
        if truth_metrics().contains(&name.as_str()) {
            return Ok(TruthMetric(name));
        }
        let help = suggest::help(&name, truth_metrics());
        Err(D::Error::custom(format!(
            "cannot have the key `{name}`, which is no measured column of the summary\n{help}"
        )))
    }
}

/// Columns of the summary that may have a truth; costs and errors have none.
fn truth_metrics() -> Vec<&'static str> {
    COLUMNS.iter().filter(|column| column.is_metric()).map(|column| column.name).collect()
}
