//! `[[event]]`: what changes while a run goes on.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::quantity::{json, non_negative};

/// `[[event]]`: change parameters while running.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EventSpec {
    /// When, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// New values under dotted names.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: BTreeMap<String, toml::Value>,
}
