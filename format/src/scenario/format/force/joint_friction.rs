//! `joint-friction`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scenario::format::robot::JointFriction;

/// Friction in joints, added to what the robot's files and `robot.joint` give. At least one of
/// `all` and `joints` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFrictionForce {
    /// The object whose joints have it; left out: the robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// Friction of every joint that `joints` does not name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub all: Option<JointFriction>,
    /// Friction by joint name.
    #[serde(default)]
    pub joints: BTreeMap<String, JointFriction>,
}

impl JointFrictionForce {
    /// Friction added to one joint; none when neither `joints` nor `all` names it.
    pub fn friction_of(&self, joint: &str) -> Option<JointFriction> {
        self.joints.get(joint).copied().or(self.all)
    }
}
