//! `[[event]]`: what changes while a run goes on.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::quantity::{json, non_negative};

/// `[[event]]`: change parameters while running, end tasks, save the robot's state, or put it back into one that was saved. At
/// least one of `set`, `end_tasks`, `save` and `restore` is given; if several are, the state is saved first and parameters are set
/// last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EventSpec {
    /// When, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// New values under dotted names, each one key in quotes: `floor.friction`, `floor.patches`, `gravity`,
    /// `contact.restitution`, `robot.payload`, `robot.joint.NAME.kp` (or `kd`, `effort`, `velocity`, `friction`,
    /// `armature`), `robot.joint_default.kp` (or `kd`), `force.N.KEY`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: BTreeMap<String, toml::Value>,
    /// Tasks that end then, by their place among the `[[task]]` of the file, from 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub end_tasks: Vec<usize>,
    /// Saves the robot's state under this name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub save: Option<String>,
    /// Puts the robot into the state that an earlier event saved under this name. Time goes on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restore: Option<String>,
}
