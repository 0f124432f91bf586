//! `spring`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::text::quantity::{angle, json, non_negative, positive, some_positive};

/// A spring and damper between a point of a link and an anchor, such as a person's hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringForce {
    /// The object it acts on; left out: the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// The link; either this or `end_effector`. Left out with `object`: its root link.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// The end effector of the robot file, with its own frame; either this or `link`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_effector: Option<String>,
    /// Point of attachment in the link's frame, m.
    #[serde(default)]
    pub point: [f64; 3],
    /// Stiffness, N/m.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub stiffness: f64,
    /// Damping of the whole relative velocity, N s/m.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub damping: f64,
    /// Length without force, m.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub rest_length: f64,
    /// The other end.
    #[serde(default)]
    pub anchor: AnchorSpec,
    /// Time at which it is attached, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Time for which it stays attached, s; left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
}

/// The far end of a spring, world axes. At most one of `velocity`, `sine` and `waypoints` is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AnchorSpec {
    /// Position at `start`, m. Left out: that of the link's point at `start`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Constant velocity from `start` on, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Oscillation about `position`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sine: Option<SineSpec>,
    /// Points with their times, which ascend.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub waypoints: Vec<WaypointSpec>,
    /// Interpolation between waypoints.
    pub path: PathShape,
}

/// An oscillation `amplitude sin(2 pi frequency (t - start) + phase)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SineSpec {
    /// Amplitude along each axis, m.
    pub amplitude: [f64; 3],
    /// Frequency, Hz.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub frequency: f64,
    /// Phase at `start`, rad.
    #[serde(default, deserialize_with = "angle")]
    #[schemars(with = "json::Angle")]
    pub phase: f64,
}

/// A point on the path of an anchor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaypointSpec {
    /// Time since the start of the run, s.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub at: f64,
    /// Position, m.
    pub position: [f64; 3],
}

/// Interpolation between waypoints of an anchor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PathShape {
    /// From rest to rest with least jerk.
    #[default]
    MinimumJerk,
    /// At constant velocity.
    Linear,
}
