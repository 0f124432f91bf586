//! `[log]` and `[stop]`: the log of a run, and rules that end it early.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::text::quantity::{json, non_negative, positive, some_positive};

/// The log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LogSpec {
    /// Records per simulated second, Hz; 0 means no log.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub rate: f64,
    /// Messages for viewers per simulated second, Hz, at most `rate`: `/tf`, `/scene/contact` and `/joint_states`.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub viewer_rate: f64,
    /// Recorded topics; events are always recorded.
    pub topics: Vec<LogTopic>,
}

impl Default for LogSpec {
    fn default() -> Self {
        let topics = vec![LogTopic::State, LogTopic::Contact, LogTopic::Scene];
        LogSpec { rate: 200.0, viewer_rate: 50.0, topics }
    }
}

/// A part of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LogTopic {
    /// Base, joints, centre of mass.
    State,
    /// Soles: states, vertices and forces.
    Contact,
    /// Frames, shapes of robot and floor, force arrows.
    Scene,
}

/// Rules that end a run early.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StopSpec {
    /// Ends the run with outcome `fallen`; left out: never.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fallen: Option<FallenRule>,
    /// What follows when collision shapes of a link are more than 1 mm below the floor. Only soles
    /// touch the floor, so other links of a fallen robot sink through it. Shapes of a foot within 1
    /// cm of its sole do not count. Robots without soles and with a fixed base are not checked. A
    /// start in that state, or with a sole that deep, is an error unless this is `"ignore"`.
    pub sunk_link: SunkLink,
    /// Ends the run at this time, s; left out: at `duration`. Plans and random draws still cover
    /// all of `duration`, so the run equals the first part of the full one.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub at: Option<f64>,
}

/// What follows when a link has sunk through the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SunkLink {
    /// The run ends with outcome `fallen`.
    #[default]
    Fallen,
    /// Nothing.
    Ignore,
}

/// Rule by which the robot has fallen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FallenRule {
    /// Height of the base's origin above the floor below which the robot has fallen, m.
    pub below: f64,
}
