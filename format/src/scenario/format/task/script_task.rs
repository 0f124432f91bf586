//! `script`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::change::ChangeSpec;
use crate::text::quantity::{json, non_negative, some_positive};

/// A task written in Luau.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScriptTask {
    /// The script, relative to the scenario file.
    pub file: String,
    /// Values for its `init`.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub params: BTreeMap<String, toml::Value>,
    /// Changes of these values, for its `change`; times ascend.
    #[serde(default)]
    pub change: Vec<ChangeSpec>,
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Longest duration, s; left out: until it reports that it is done.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
}
