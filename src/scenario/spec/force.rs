//! `[[force]]`: what acts on the robot besides gravity and the floor.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{robot::JointFriction, tagged::tagged};
use crate::scenario::quantity::{json, non_negative, positive};

tagged! {
    /// One external force.
    ForceSpec, "force" {
        /// A force on a link for a time, with a profile.
        "push" => Push(PushForce),
        /// A force on a link throughout, or for a time.
        "constant" => Constant(ConstantForce),
        /// Friction in joints, beside what the robot's files give.
        "joint-friction" => JointFriction(JointFrictionForce),
    }
}

/// Axes that a force and a moment are given in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ForceFrame {
    /// The world's.
    #[default]
    World,
    /// The link's, turning with it.
    Link,
}

/// How a push rises and ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// Full from `start` to `start + duration`.
    #[default]
    Constant,
    /// Half a sine wave, full in the middle.
    HalfSine,
    /// Linear from 0 at `start` to full at `start + duration`, and stays.
    Ramp,
    /// Linear up to full in the middle and down again.
    Triangle,
}

/// A force on a link for a time. At least one of `force` and `moment` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PushForce {
    /// The link.
    pub link: String,
    /// Where it acts, in the link's frame, m.
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
    /// When it starts, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// How long it lasts, s.
    #[serde(default = "tenth", deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub duration: f64,
    /// How it rises and ends.
    #[serde(default)]
    pub profile: Profile,
}

fn tenth() -> f64 {
    0.1
}

/// A constant force on a link. At least one of `force` and `moment` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantForce {
    /// The link.
    pub link: String,
    /// Where it acts, in the link's frame, m.
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
    /// When it starts, s.
    #[serde(default, deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub start: f64,
    /// How long it lasts, s; left out: to the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_positive")]
    #[schemars(with = "Option<json::Positive>")]
    pub duration: Option<f64>,
}

fn some_positive<'de, D: serde::Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    positive(d).map(Some)
}

/// Friction in joints, added to what the robot's files and `robot.joint` give. At least one of `all` and `joints` is
/// given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFrictionForce {
    /// Friction of every joint that `joints` does not name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub all: Option<JointFriction>,
    /// Friction by joint name.
    #[serde(default)]
    pub joints: BTreeMap<String, JointFriction>,
}

impl JointFrictionForce {
    /// Friction added to one joint; none when neither `joints` nor `all` speaks of it.
    pub fn of(&self, joint: &str) -> Option<JointFriction> {
        self.joints.get(joint).copied().or(self.all)
    }
}
