//! `push`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::defaults;
use crate::scenario::format::force::ForceFrame;
use crate::text::quantity::{json, non_negative, positive};

/// Time profile of a push.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// Full from `start` to `start + duration`.
    #[default]
    Constant,
    /// Half a sine wave, full in the middle.
    HalfSine,
    /// Linear from 0 at `start` to full at `start + duration`, then constant.
    Ramp,
    /// Linear up to full in the middle and down again.
    Triangle,
}

/// A force on a link for a time. At least one of `force` and `moment` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PushForce {
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
    /// Greatest force, N.
    #[serde(default)]
    pub force: [f64; 3],
    /// Greatest moment about the point, N m.
    #[serde(default)]
    pub moment: [f64; 3],
    /// Axes of `force` and `moment`.
    #[serde(default)]
    pub frame: ForceFrame,
    /// Start, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// Duration, s.
    #[serde(default = "defaults::tenth", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub duration: f64,
    /// Time profile.
    #[serde(default)]
    pub profile: Profile,
}
