//! `constant`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::force::ForceFrame;
use crate::text::quantity::{json, non_negative, some_positive};

/// A constant force on a link. At least one of `force` and `moment` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantForce {
    /// The object it acts on; left out: the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// The link; either this or `end_effector`. Left out with `object`: its root link.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// The end effector of the robot file, with its own frame; either this or `link`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_effector: Option<String>,
    /// Point of application in the link's frame, m.
    #[serde(default)]
    pub point: [f64; 3],
    /// Force, N.
    #[serde(default)]
    pub force: [f64; 3],
    /// Moment about the point, N m.
    #[serde(default)]
    pub moment: [f64; 3],
    /// Axes of `force` and `moment`.
    #[serde(default)]
    pub frame: ForceFrame,
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Duration, s; left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
}
