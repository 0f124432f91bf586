//! `[self_collision]`: detection and avoidance of collisions of the robot with itself.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::text::quantity::{json, non_negative, positive};

/// Measures distances between the robot's bodies; methods 1 to 4 keep joint commands free of
/// collisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SelfCollisionSpec {
    /// 0 only reports. 1 to 4 avoid: 1 stops all joints, 2 those between the bodies, 3 also tries
    /// random postures of these, 4 first searches for a path around.
    #[serde(deserialize_with = "up_to_four")]
    #[schemars(range(max = 4))]
    pub method: u8,
    /// Cycles of avoidance per second, Hz.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub rate: f64,
    /// Distance that avoidance maintains, m.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub margin: f64,
    /// Greatest joint speed that avoidance commands, rad/s or m/s; the joint's own limit if that is
    /// smaller.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub max_speed: f64,
    /// Greatest acceleration, rad/s^2 or m/s^2.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub max_acceleration: f64,
    /// Greatest jerk, rad/s^3 or m/s^3.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub max_jerk: f64,
}

impl Default for SelfCollisionSpec {
    fn default() -> Self {
        SelfCollisionSpec {
            method: 2,
            rate: 10.0,
            margin: 0.005,
            max_speed: 10.0,
            max_acceleration: 50.0,
            max_jerk: 1000.0,
        }
    }
}

fn up_to_four<'de, D: Deserializer<'de>>(d: D) -> Result<u8, D::Error> {
    match u32::deserialize(d)? {
        n @ 0..=4 => Ok(n as u8),
        n => Err(D::Error::custom(format!("must be from 0 to 4, not {n}"))),
    }
}
