//! `squat`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::quantity::{count, json, non_negative, positive};

/// Lower the centre of mass and raise it again over the middle of the soles, which stay where they are; the root link
/// stays upright.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SquatTask {
    /// When it starts, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// How far the centre of mass goes down, m; below zero it rises first.
    pub depth: f64,
    /// Time of going down and up, s.
    #[serde(default = "two", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub period: f64,
    /// How often.
    #[serde(default = "one", deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub repetitions: u32,
    /// Time to bring the centre of mass over the middle of the soles first, s.
    #[serde(default = "second", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub settle: f64,
    /// Are the joints that carry given the efforts that the motion takes, besides positions?
    #[serde(default = "yes")]
    pub feed_forward: bool,
}

fn one() -> u32 {
    1
}

fn second() -> f64 {
    1.0
}

fn two() -> f64 {
    2.0
}

fn yes() -> bool {
    true
}
