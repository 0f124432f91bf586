//! `gravity-compensation`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::text::quantity::{fraction, json, non_negative, positive, some_fraction, some_non_negative, some_positive};

/// Commands efforts that carry the robot in any posture and yield to pushes: the force control of
/// `balance` without a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravityCompensationTask {
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Duration, s. Left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
    /// The supporting soles. Left out: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub soles: Option<Vec<String>>,
    /// Damping of every joint: deceleration per velocity, 1/s.
    #[serde(default = "defaults::two", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub damping: f64,
    /// Friction coefficient that contact forces may use.
    #[serde(default = "defaults::half", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub friction: f64,
    /// Distance of contact forces from the edges of each sole: 0 permits its edges, 1 only its
    /// centre.
    #[serde(default = "defaults::tenth", deserialize_with = "fraction")]
    #[schemars(with = "json::Fraction")]
    pub margin: f64,
    /// New values at given times, ascending.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub change: Vec<CompensationChange>,
}

/// New values from a time on; values left out stay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompensationChange {
    /// Simulated time, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// Damping of every joint, 1/s.
    #[serde(default, deserialize_with = "some_non_negative", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub damping: Option<f64>,
    /// Friction coefficient that contact forces may use.
    #[serde(default, deserialize_with = "some_positive", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Positive>")]
    pub friction: Option<f64>,
    /// Distance of contact forces from the edges of each sole, 0 to 1.
    #[serde(default, deserialize_with = "some_fraction", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Fraction>")]
    pub margin: Option<f64>,
}
