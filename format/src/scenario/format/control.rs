//! `[control]`: the task server and its estimate of the base.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::text::quantity::{fraction, json, positive};

/// Highest rate, Hz: a microsecond between ticks.
pub const MAX_RATE: f64 = 1e6;

fn rate<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    let rate = positive(d)?;
    if rate > MAX_RATE {
        return Err(D::Error::custom(format!("must be at most {MAX_RATE} Hz, not {rate}")));
    }
    Ok(rate)
}

/// The task server.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ControlSpec {
    /// Rate of tasks and sensors, Hz; at most 1e6.
    #[serde(deserialize_with = "rate")]
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = MAX_RATE))]
    pub rate: f64,
    /// True: the server ticks also while no task runs, and steps end at each tick. An event at a
    /// tick then changes no step before it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub idle_ticks: bool,
    /// What position servos follow between two ticks.
    #[serde(skip_serializing_if = "Interpolation::is_default")]
    pub interpolation: Interpolation,
    /// Source of the base's state for tasks.
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
            interpolation: Interpolation::Hold,
            estimator: Estimator::Truth,
            kinematic: KinematicSpec::default(),
            inertial: InertialSpec::default(),
        }
    }
}

/// What position servos follow between two ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// The last command.
    #[default]
    Hold,
    /// A cubic to the next command, extrapolated from the last two: desired positions and velocities are continuous.
    Cubic,
    /// The commands of tasks `posture`, `sine` and `playback` as functions of time, without ticks that would
    /// bring nothing new. Elsewhere as `cubic`.
    Continuous,
}

impl Interpolation {
    fn is_default(&self) -> bool {
        *self == Interpolation::default()
    }
}

/// Source of the base's state for tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// The simulated state.
    Truth,
    /// Measured orientation and joint angles, and soles at rest.
    Kinematic,
    /// Integrated gyroscope and accelerometer, or sole forces.
    Inertial,
}

/// How the kinematic estimator decides which soles rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct KinematicSpec {
    /// A sole rests while it carries more than this fraction of the robot's weight.
    #[serde(deserialize_with = "fraction")]
    #[schemars(with = "json::Fraction")]
    pub threshold: f64,
    /// Soles that always rest; left out: decided by load.
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

/// Parameters of the inertial estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct InertialSpec {
    /// Source of the acceleration.
    pub acceleration: AccelerationSource,
}

impl InertialSpec {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Source of the inertial estimator's acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AccelerationSource {
    /// The accelerometer.
    #[default]
    Accelerometer,
    /// The sole forces, which accelerate the centre of mass; other forces are not seen.
    Soles,
}
