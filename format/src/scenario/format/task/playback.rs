//! `playback`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::text::quantity::{json, non_negative, positive};

/// Plays a motion file: postures at times, joined by curves of least jerk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaybackTask {
    /// The motion: postures (`.toml`), a table of joint positions over time (`.csv`) or the log of
    /// a run (`.mcap`), relative to this file.
    #[schemars(length(min = 1))]
    pub file: String,
    /// Simulated time of time 0 of the motion, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Seconds of the motion per simulated second.
    #[serde(default = "defaults::one", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub speed: f64,
    /// Boundary conditions at the first and last posture; left out: clamped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends: Option<Ends>,
    /// Repeats without end; the motion must end in its first posture.
    #[serde(default, rename = "loop")]
    pub repeat: bool,
    /// Time in which the commands at `start` blend into the motion, and one speed into the next, s;
    /// 0: at once.
    #[serde(default = "defaults::half", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub blend: f64,
    /// The joints that play, by name; empty: all that the motion names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<String>,
    /// Positions of a log that are played.
    #[serde(default)]
    pub recorded: Recorded,
    /// New speeds at given times, ascending.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub change: Vec<PlaybackChange>,
}

/// A new speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaybackChange {
    /// Simulated time, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// Seconds of the motion per simulated second; 0 holds it.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub speed: f64,
}

/// Boundary conditions of a motion that does not repeat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ends {
    /// Zero velocity and acceleration.
    #[default]
    Clamped,
    /// Velocity and acceleration that minimize jerk.
    Natural,
}

/// Positions of a log that are played.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Recorded {
    /// Commanded positions.
    #[default]
    Desired,
    /// Actual positions.
    Actual,
}
