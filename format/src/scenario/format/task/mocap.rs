//! `mocap`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::text::quantity::{angle, json, non_negative, positive, some_positive};

/// Follows captured motion: channels of a BVH or CSV file mapped to joints, kept within their
/// ranges and speeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MocapTask {
    /// The recording (`.bvh` or `.csv`), relative to this file.
    #[schemars(length(min = 1))]
    pub file: String,
    /// Simulated time of time 0 of the recording, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Seconds of the recording per simulated second.
    #[serde(default = "defaults::one", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub speed: f64,
    /// Time in which the commands at `start` blend into the motion, s; 0: at once.
    #[serde(default = "defaults::half", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub blend: f64,
    /// Width of the averaging window, s; 0: no averaging.
    #[serde(default = "defaults::tenth", deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub smoothing: f64,
    /// Greatest commanded speed of any joint, rad/s or m/s, in addition to the joint's own limit.
    #[serde(default, deserialize_with = "some_positive", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<json::Positive>")]
    pub speed_limit: Option<f64>,
    /// Channel by name (`"LeftArm.Xrotation"`, or a column of the CSV) to joint.
    pub map: BTreeMap<String, MocapTarget>,
}

/// Target of a channel: `q = offset + scale value`, value in rad where the channel is a rotation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MocapTarget {
    /// Joint.
    pub joint: String,
    /// Factor, such as -1 for an axis of opposite direction.
    #[serde(default = "defaults::one")]
    pub scale: f64,
    /// Joint position at channel value 0, rad or m.
    #[serde(default, deserialize_with = "angle")]
    #[schemars(with = "json::Angle")]
    pub offset: f64,
}
