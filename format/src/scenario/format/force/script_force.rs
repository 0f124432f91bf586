//! `script`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::change::ChangeSpec;
use crate::text::quantity::{json, non_negative, some_positive};

/// Forces computed by a script in Luau.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScriptForce {
    /// The object it acts on, which takes the place of the robot in the script; left out: the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// The script, relative to the scenario file.
    pub file: String,
    /// Values for its `init`.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub params: BTreeMap<String, toml::Value>,
    /// Changes of these values, for its `change`; times ascend.
    #[serde(default)]
    pub change: Vec<ChangeSpec>,
    /// Times at which its forces jump or have a kink, s; `start`, the end and changes are included
    /// anyway.
    #[serde(default)]
    pub corners: Vec<f64>,
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Duration, s; left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
}
