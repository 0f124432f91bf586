//! `[control]`: the task server and what it knows of the base.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::scenario::format::quantity::{fraction, json, positive};

/// Highest rate, Hz: a microsecond between ticks.
pub const FASTEST: f64 = 1e6;

fn rate<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    let rate = positive(d)?;
    if rate > FASTEST {
        return Err(D::Error::custom(format!("must be at most {FASTEST} Hz, not {rate}")));
    }
    Ok(rate)
}

/// The task server.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ControlSpec {
    /// How often tasks run and sensors are read, Hz.
    /// At most 1e6.
    #[serde(deserialize_with = "rate")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = FASTEST))]
    pub rate: f64,
    /// Does the server tick, and with it every step end, while no task runs? Each tick is then an instant at which an event can
    /// be put without changing the steps before it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub idle_ticks: bool,
    /// Where tasks have the base's state from.
    pub estimator: Estimator,
    /// Parameters of estimator `kinematic`.
    #[serde(skip_serializing_if = "KinematicSpec::is_default")]
    pub kinematic: KinematicSpec,
    /// Parameters of estimator `inertial`.
    #[serde(skip_serializing_if = "InertialSpec::is_default")]
    pub inertial: InertialSpec,
}

impl Default for ControlSpec {
    fn default() -> Self {
        ControlSpec {
            rate: 1000.0,
            idle_ticks: false,
            estimator: Estimator::Truth,
            kinematic: KinematicSpec::default(),
            inertial: InertialSpec::default(),
        }
    }
}

/// Where tasks have the base's state from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// The simulated state itself.
    Truth,
    /// Measured orientation and joint angles, and soles that stand still.
    Kinematic,
    /// Integrated gyroscope and accelerometer, or sole forces.
    Inertial,
}

/// How the kinematic estimator tells which soles stand still.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct KinematicSpec {
    /// A sole stands still while the floor carries more than this part of the robot's weight on it.
    #[serde(deserialize_with = "fraction")]
    #[schemars(with = "json::Fraction")]
    pub threshold: f64,
    /// These soles stand still, whatever they carry; left out: by their loads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub static_soles: Option<Vec<String>>,
}

impl Default for KinematicSpec {
    fn default() -> Self {
        KinematicSpec { threshold: 0.05, static_soles: None }
    }
}

impl KinematicSpec {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// What the inertial estimator integrates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct InertialSpec {
    /// Where it has the acceleration from.
    pub acceleration: AccelerationSource,
}

impl InertialSpec {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Where the inertial estimator has the acceleration from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AccelerationSource {
    /// The accelerometer.
    #[default]
    Accelerometer,
    /// The sole forces, which accelerate the centre of mass; other forces go unnoticed.
    Soles,
}
