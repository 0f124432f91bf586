//! `walk`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::text::quantity::{count, json, non_negative, positive, some_positive};

/// Walks with two feet along a straight line, or steps on the spot. The centre of mass follows from
/// the zero-moment point by preview control.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WalkTask {
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Number of footfalls.
    #[serde(default = "six", deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub steps: u32,
    /// Distance of each footfall ahead of the other foot, m; 0: on the spot, negative: backwards.
    #[serde(default)]
    pub step_length: f64,
    /// Height of each footfall above the other foot, m: stairs; negative: down.
    #[serde(default, skip_serializing_if = "defaults::is_zero")]
    pub step_rise: f64,
    /// Time from one footfall to the next, s.
    #[serde(default = "step_time", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub step_time: f64,
    /// The part of it with both feet on the floor, s.
    #[serde(default = "double_support", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub double_support: f64,
    /// Height of the swinging sole, m.
    #[serde(default = "step_height", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub step_height: f64,
    /// Height of the centre of mass above the soles, m; left out: the initial one.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub com_height: Option<f64>,
    /// Sole that swings first; left out: the robot's first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first: Option<String>,
    /// Time in which the centre of mass first moves to its height over the middle of the soles, s.
    #[serde(default = "defaults::one", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub settle: f64,
    /// True commands the carrying joints the efforts of the motion in addition to positions.
    #[serde(default = "defaults::yes")]
    pub feed_forward: bool,
    /// Time before the first step and after the last with sway of the centre of mass only, s.
    #[serde(default = "defaults::one", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub wait: f64,
}

fn six() -> u32 {
    6
}

fn step_time() -> f64 {
    0.8
}

fn double_support() -> f64 {
    0.2
}

fn step_height() -> f64 {
    0.015
}
