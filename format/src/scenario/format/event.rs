//! `[[event]]`: changes during a run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::text::quantity::{json, non_negative};

/// Changes parameters during the run, ends tasks, saves the robot's state or restores a saved one.
/// At least one of `set`, `end_tasks`, `save` and `restore` is given. The state is saved first, and
/// parameters are set last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EventSpec {
    /// Time, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// New values by dotted key, each key in quotes: `floor.friction`, `floor.patches`, `gravity`,
    /// `contact.restitution`, `robot.payload`, `robot.joint.NAME.kp` (or `kd`, `effort`,
    /// `velocity`, `friction`, `armature`), `robot.joint_default.kp` (or `kd`), `force.N.KEY`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: BTreeMap<String, toml::Value>,
    /// Tasks that end, by index among the `[[task]]` of the file, from 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub end_tasks: Vec<usize>,
    /// Saves the robot's state under this name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub save: Option<String>,
    /// Restores the state that an earlier event saved under this name. Time is not reset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restore: Option<String>,
}
