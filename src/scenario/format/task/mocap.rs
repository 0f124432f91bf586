//! `mocap`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::quantity::{angle, json, non_negative, positive, some_positive};

/// Follow captured motion: channels of a BVH or CSV file mapped to joints, kept within their ranges and speeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MocapTask {
    /// The recording (`.bvh` or `.csv`), relative to this file.
    #[schemars(length(min = 1))]
    pub file: String,
    /// When time 0 of the recording is, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Seconds of the recording per simulated second.
    #[serde(default = "one", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub speed: f64,
    /// Time in which what joints are asked at `start` fades into the motion, s; 0: at once.
    #[serde(default = "half", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub blend: f64,
    /// Width of the window over which the motion is averaged, s; 0: as it is.
    #[serde(default = "tenth", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub smoothing: f64,
    /// Greatest speed asked of any joint, rad/s or m/s, beside the joint's own limit.
    #[serde(default, deserialize_with = "some_positive", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Positive>")]
    pub speed_limit: Option<f64>,
    /// Channel by name (`"LeftArm.Xrotation"`, or a column of the CSV) to joint.
    pub map: BTreeMap<String, MocapTarget>,
}

/// Where a channel goes: `q = offset + scale value`, value in rad where the channel is a rotation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MocapTarget {
    /// Joint.
    pub joint: String,
    /// Factor, such as -1 for an axis that points the other way.
    #[serde(default = "one")]
    pub scale: f64,
    /// Joint position at channel value 0, rad or m.
    #[serde(default, deserialize_with = "angle")]
    #[schemars(with = "json::Angle")]
    pub offset: f64,
}

fn one() -> f64 {
    1.0
}

fn half() -> f64 {
    0.5
}

fn tenth() -> f64 {
    0.1
}
