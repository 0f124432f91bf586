//! `sine`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::text::quantity::{angle, json, non_negative, positive, some_angle, some_positive};

/// Moves joints sinusoidally: `q = offset + amplitude sin(2 pi frequency t + phase)`, t from
/// `start`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SineTask {
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// How long it lasts, s, both ramps included; left out: to the end of the run.
    #[serde(default, deserialize_with = "some_positive", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
    /// Time of each transition, s: from the commanded positions to the oscillation, back at the end
    /// of `duration`, and between sets of parameters; 0: at once.
    #[serde(default = "defaults::half", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub ramp: f64,
    /// The joints by name.
    pub joints: BTreeMap<String, SineJoint>,
    /// New parameters at given times, ascending.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub change: Vec<SineChange>,
}

/// Oscillation of one joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SineJoint {
    /// Amplitude, rad or m.
    #[serde(deserialize_with = "angle")]
    #[schemars(with = "json::Angle")]
    pub amplitude: f64,
    /// Frequency, Hz.
    #[serde(default = "defaults::one", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub frequency: f64,
    /// Phase at `start`, rad.
    #[serde(default, deserialize_with = "angle")]
    #[schemars(with = "json::Angle")]
    pub phase: f64,
    /// Middle of the oscillation, rad or m; left out: the position commanded at `start`.
    #[serde(default, deserialize_with = "some_angle", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Angle>")]
    pub offset: Option<f64>,
}

/// New parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SineChange {
    /// Simulated time, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// Changes by joint name.
    pub joints: BTreeMap<String, SineJointChange>,
}

/// Changes of one joint. The phase is continuous.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SineJointChange {
    /// Amplitude, rad or m.
    #[serde(deserialize_with = "some_angle", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Angle>")]
    pub amplitude: Option<f64>,
    /// Frequency, Hz.
    #[serde(deserialize_with = "some_positive", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Positive>")]
    pub frequency: Option<f64>,
    /// Middle of the oscillation, rad or m.
    #[serde(deserialize_with = "some_angle", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Angle>")]
    pub offset: Option<f64>,
}
