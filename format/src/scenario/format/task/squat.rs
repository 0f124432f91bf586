//! `squat`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::text::quantity::{count, json, non_negative, positive};

/// Lowers the centre of mass and raises it again over the middle of the soles. The soles do not
/// move, and the root link stays upright.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SquatTask {
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Depth of the centre of mass, m; negative: it rises first.
    pub depth: f64,
    /// Time of one cycle, down and up, s.
    #[serde(default = "defaults::two", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub period: f64,
    /// Number of cycles.
    #[serde(default = "one", deserialize_with = "count")]
    #[schemars(with = "json::Count")]
    pub repetitions: u32,
    /// Time in which the centre of mass first moves over the middle of the soles, s.
    #[serde(default = "defaults::one", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub settle: f64,
    /// True commands the carrying joints the efforts of the motion in addition to positions.
    #[serde(default = "defaults::yes")]
    pub feed_forward: bool,
}

fn one() -> u32 {
    1
}
