//! `walk`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::quantity::{count, json, non_negative, positive, some_positive};

/// Walk with two feet along a straight line, or step in place; the centre of mass follows from the zero-moment point by
/// preview control.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WalkTask {
    /// When it starts, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Number of footfalls.
    #[serde(default = "six", deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub steps: u32,
    /// How far each footfall is ahead of the other foot, m; 0 steps in place, below zero goes backwards.
    #[serde(default)]
    pub step_length: f64,
    /// Time from one footfall to the next, s.
    #[serde(default = "step_time", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub step_time: f64,
    /// The part of it in which both feet stand, s.
    #[serde(default = "double_support", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub double_support: f64,
    /// How high the swinging sole rises, m.
    #[serde(default = "step_height", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub step_height: f64,
    /// Height of the centre of mass above the soles, m; left out: as at the start.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub com_height: Option<f64>,
    /// Sole that swings first; left out: the robot's first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first: Option<String>,
    /// Time to bring the centre of mass to its height over the middle of the soles first, s.
    #[serde(default = "second", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub settle: f64,
    /// Are the joints that carry given the efforts that the motion takes, besides positions?
    #[serde(default = "yes")]
    pub feed_forward: bool,
    /// Time before the first step and after the last in which the centre of mass sways only, s.
    #[serde(default = "second", deserialize_with = "non_negative")]
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

fn second() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}
