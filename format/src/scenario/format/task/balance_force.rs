//! Settings of `balance` with `control = "force"`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::text::quantity::{fraction, json, non_negative, positive, some_fraction, some_non_negative, some_positive};

/// Gains and assumptions of the force-controlled balance. Gains are accelerations per displacement
/// (1/s^2) and per velocity (1/s), to be multiplied by the robot's own mass and inertias, so that
/// they suit robots of any size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ForceBalance {
    /// Gains of the centre of mass towards its reference.
    pub com: Gains,
    /// Gains of the base's orientation towards the initial one. Left out: 100 and 20, less at rates
    /// below 1 kHz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Gains>,
    /// Gains of all joints towards their commanded positions, as far as that moves neither centre
    /// of mass nor base nor soles. `kd` always damps every joint. Left out: 25 and 10, less at
    /// rates below 1 kHz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<Gains>,
    /// Displacement of the reference of the centre of mass from its default, above the point of
    /// optimal stability of the soles at its initial height; world axes, m.
    pub offset: [f64; 3],
    /// Time in which the reference of the centre of mass moves from its present position to the
    /// target, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub approach: f64,
    /// Friction coefficient that contact forces may use.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub friction: f64,
    /// Distance of contact forces from the edges of each sole: 0 permits its edges, 1 only its
    /// centre.
    #[serde(deserialize_with = "fraction")]
    #[schemars(with = "json::Fraction")]
    pub margin: f64,
    /// Vertices of the soles that may carry load.
    pub contacts: Contacts,
}

impl Default for ForceBalance {
    fn default() -> Self {
        ForceBalance {
            com: Gains { kp: 100.0, kd: 20.0 },
            orientation: None,
            joints: None,
            offset: [0.0; 3],
            approach: 1.0,
            friction: 0.5,
            margin: 0.1,
            contacts: Contacts::Assumed,
        }
    }
}

/// Acceleration per displacement and per velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gains {
    /// Per displacement, 1/s^2.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub kp: f64,
    /// Per velocity, 1/s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub kd: f64,
}

/// Vertices of the soles that are assumed to carry load.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Contacts {
    /// All, without sensing.
    #[default]
    Assumed,
    /// Those in contact at the previous tick.
    Sensed,
}

/// New values; values left out stay. Gains apply at once; the reference of the centre of mass moves
/// to a new `offset` from its present position.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ForceBalanceChange {
    /// Gains of the centre of mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub com: Option<Gains>,
    /// Gains of the base's orientation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Gains>,
    /// Gains of all joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<Gains>,
    /// Displacement of the reference of the centre of mass from its default, world axes, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<[f64; 3]>,
    /// Time in which the reference moves, for this and later changes, s.
    #[serde(deserialize_with = "some_non_negative", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::NonNegative>")]
    pub approach: Option<f64>,
    /// Friction coefficient that contact forces may use.
    #[serde(deserialize_with = "some_positive", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Positive>")]
    pub friction: Option<f64>,
    /// Distance of contact forces from the edges of each sole, 0 to 1.
    #[serde(deserialize_with = "some_fraction", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Fraction>")]
    pub margin: Option<f64>,
}
