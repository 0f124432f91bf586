//! Parts of the format that are read and checked but that no run can honour yet; see `availability`.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::scenario::quantity::{json, non_negative, positive};

/// `[self_collision]`: what happens when the robot is about to touch itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SelfCollisionSpec {
    /// 0 only reports; 1 to 4 avoid.
    #[serde(deserialize_with = "up_to_four")]
    #[schemars(range(max = 4))]
    pub method: u8,
    /// Checks per second, Hz.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub rate: f64,
    /// Distance that counts as touching, m.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub margin: f64,
}

impl Default for SelfCollisionSpec {
    fn default() -> Self {
        SelfCollisionSpec { method: 2, rate: 10.0, margin: 0.005 }
    }
}

fn up_to_four<'de, D: Deserializer<'de>>(d: D) -> Result<u8, D::Error> {
    match u32::deserialize(d)? {
        n @ 0..=4 => Ok(n as u8),
        n => Err(D::Error::custom(format!("must be from 0 to 4, not {n}"))),
    }
}
