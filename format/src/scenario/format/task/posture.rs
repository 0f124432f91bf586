//! `posture`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::text::quantity::{joint_positions, json, non_negative, positive};

/// Moves joints from their present positions to a posture along minimum-jerk curves, and holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PostureTask {
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Duration of the motion, s.
    #[serde(default = "defaults::one", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub duration: f64,
    /// Goal by joint name, rad or m.
    #[serde(deserialize_with = "joint_positions")]
    #[schemars(with = "BTreeMap<String, json::Angle>")]
    pub joints: BTreeMap<String, f64>,
}
