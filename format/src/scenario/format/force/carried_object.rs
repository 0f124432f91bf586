//! `carried-object`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::text::quantity::{angles, json, non_negative, positive, some_positive};

/// A rigid object that a link holds for a time: while held it is part of the link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CarriedObject {
    /// The link that holds it; either this or `end_effector`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// The end effector of the robot file that holds it, with its own frame; either this or `link`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_effector: Option<String>,
    /// Mass, kg.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw of its axes in the link's frame, rad.
    #[serde(default, deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub rpy: [f64; 3],
    /// `[ixx, iyy, izz, ixy, ixz, iyz]` about its centre of mass in its axes, kg m^2. Left out: a
    /// point mass.
    #[serde(default)]
    pub inertia: [f64; 6],
    /// Velocity at which it arrives, without rotation, world axes, m/s: grasping it is an impact.
    /// Left out: it already moves with the link.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Time at which it is grasped, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Time for which it is held, s; left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
}
