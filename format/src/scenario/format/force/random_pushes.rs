//! `random-pushes`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::force::Profile;
use crate::text::quantity::{json, non_negative, some_count, some_positive};

/// Pushes drawn at random from the run's seed. Exactly one of `number` and `rate` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomPushes {
    /// The object it acts on; left out: the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// The links, each equally likely. Left out with `object`: its root link.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<String>,
    /// Point of application in the link's frame, m.
    #[serde(default)]
    pub point: [f64; 3],
    /// Number of pushes, at independent uniform times.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_count")]
    pub number: Option<u32>,
    /// Mean rate of pushes, as a Poisson process, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub rate: Option<f64>,
    /// Least and greatest peak force, N.
    pub magnitude: [f64; 2],
    /// Shortest and longest push, s.
    #[serde(default = "tenth")]
    pub push_duration: [f64; 2],
    /// Directions, each equally likely.
    #[serde(default)]
    pub direction: Directions,
    /// Time profile of each; not `ramp`.
    #[serde(default)]
    pub profile: Profile,
    /// Time from which pushes may begin, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Length of that time, s; left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
}

/// Directions of random pushes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Directions {
    /// Perpendicular to the world's z axis.
    #[default]
    Horizontal,
    /// All directions.
    Any,
}

fn tenth() -> [f64; 2] {
    [0.1, 0.1]
}
