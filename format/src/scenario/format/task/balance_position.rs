//! Settings of `balance` with `control = "position"`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::text::quantity::{json, non_negative, positive, some_non_negative, some_positive};

/// Gains of the position-controlled balance: displacements of the centre of mass against its error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PositionBalance {
    /// Commanded displacement per error of the centre of mass, m/m.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub proportional: f64,
    /// Commanded displacement against its velocity, s. Left out: 0.1, or more under a slower
    /// pendulum.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub damping: Option<f64>,
    /// Rate of displacement per error, 1/s: removes the remaining sag.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub integral: f64,
    /// Rate of displacement per distance of the zero-moment point from the reference, 1/s: leans
    /// against a lasting push. Left out: 2, or a third of sqrt(g/h) if that is less.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_non_negative")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub leaning: Option<f64>,
    /// Greatest displacement along x and along y, m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub reach: f64,
    /// Rate at which joints return to the posture of the start as far as soles and centre of mass
    /// allow, 1/s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub posture: f64,
    /// Time in which the balance takes effect, s.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub approach: f64,
    /// Displacement of the reference from the point of optimal stability, world axes, m.
    pub offset: [f64; 2],
    /// Mobility of joints by name: 0 excludes one. Left out: 1 for those that move a sole, 0 for
    /// the others.
    pub mobility: BTreeMap<String, f64>,
    /// True commands the carrying joints efforts against gravity in addition to positions.
    pub feed_forward: bool,
}

impl Default for PositionBalance {
    fn default() -> Self {
        PositionBalance {
            proportional: 0.0,
            damping: None,
            integral: 0.0,
            leaning: None,
            reach: 0.05,
            posture: 2.0,
            approach: 0.5,
            offset: [0.0; 2],
            mobility: BTreeMap::new(),
            feed_forward: true,
        }
    }
}

/// New values; values left out stay. Gains apply at once; the reference moves to a new `offset`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PositionBalanceChange {
    /// Commanded displacement per error of the centre of mass, m/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proportional: Option<f64>,
    /// Commanded displacement against its velocity, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Rate of displacement per error, 1/s.
    #[serde(deserialize_with = "some_non_negative", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub integral: Option<f64>,
    /// Rate of displacement per distance of the zero-moment point from the reference, 1/s.
    #[serde(deserialize_with = "some_non_negative", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub leaning: Option<f64>,
    /// Rate at which joints return to the posture of the start, 1/s.
    #[serde(deserialize_with = "some_non_negative", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub posture: Option<f64>,
    /// Displacement of the reference from the point of optimal stability, world axes, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<[f64; 2]>,
    /// Time in which the reference moves, for this and later changes, s.
    #[serde(deserialize_with = "some_positive", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Positive>")]
    pub approach: Option<f64>,
}
