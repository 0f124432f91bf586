//! `[sensors]`: errors of the readings that tasks and estimators receive.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::text::quantity::{angles, json, non_negative};

/// Longest delay, s: delayed readings are kept in memory.
const MAX_DELAY: f64 = 10.0;

/// Errors of the sensors. A sensor that is left out has no error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SensorsSpec {
    /// Name of the robot's IMU. Left out: the first of the robot file; without one, the base's
    /// frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imu: Option<String>,
    /// Joint positions, rad or m.
    #[serde(skip_serializing_if = "SensorError::is_none")]
    pub joint_position: SensorError,
    /// Joint velocities, rad/s or m/s.
    #[serde(skip_serializing_if = "SensorError::is_none")]
    pub joint_velocity: SensorError,
    /// Joint loads, N m or N.
    #[serde(skip_serializing_if = "SensorError::is_none")]
    pub joint_load: SensorError,
    /// Orientation of the IMU.
    #[serde(skip_serializing_if = "OrientationError::is_none")]
    pub orientation: OrientationError,
    /// Angular velocity of the IMU in its own axes, rad/s.
    #[serde(skip_serializing_if = "SensorError::is_none")]
    pub gyroscope: SensorError,
    /// Specific force at the IMU's origin in its own axes, m/s^2.
    #[serde(skip_serializing_if = "SensorError::is_none")]
    pub accelerometer: SensorError,
    /// Components of the force on each sole, N.
    #[serde(skip_serializing_if = "SensorError::is_none")]
    pub sole_force: SensorError,
    /// Components of the moment on each sole, N m.
    #[serde(skip_serializing_if = "SensorError::is_none")]
    pub sole_moment: SensorError,
}

impl SensorsSpec {
    /// True when the scenario sets no sensor error.
    pub fn is_none(&self) -> bool {
        *self == SensorsSpec::default()
    }
}

/// Errors of a sensor, in the unit of its readings, the same for each of its channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SensorError {
    /// Standard deviation of white normal noise per reading.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub noise: f64,
    /// Added to every reading.
    pub bias: f64,
    /// Readings are multiples of this; 0: no rounding.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub resolution: f64,
    /// Age of a reading, s; at most 10.
    #[serde(deserialize_with = "delay")]
    #[schemars(range(min = 0, max = MAX_DELAY))]
    pub delay: f64,
}

impl SensorError {
    /// True without any error.
    pub fn is_none(&self) -> bool {
        *self == SensorError::default()
    }
}

/// Errors of a measured orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OrientationError {
    /// Standard deviation of the rotation about each of the IMU's axes, white and normal, rad.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub noise: f64,
    /// Constant rotation in the IMU's axes, as a rotation vector, rad.
    #[serde(deserialize_with = "angles")]
    #[schemars(with = "[json::Angle; 3]")]
    pub bias: [f64; 3],
    /// Age of a reading, s; at most 10.
    #[serde(deserialize_with = "delay")]
    #[schemars(range(min = 0, max = MAX_DELAY))]
    pub delay: f64,
}

impl OrientationError {
    /// True without any error.
    pub fn is_none(&self) -> bool {
        *self == OrientationError::default()
    }
}

fn delay<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    let seconds = non_negative(d)?;
    if seconds > MAX_DELAY {
        return Err(D::Error::custom(format!("must be at most {MAX_DELAY} s, not {seconds}")));
    }
    Ok(seconds)
}
