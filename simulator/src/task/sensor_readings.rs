//! Sensor readings at a control tick. With [`super::Command`] they are the whole interface between
//! tasks and a robot, whether simulated here, remote, or real.

use crate::dynamics::chain::FrameMotion;
use crate::robot::Model;
use nalgebra::{UnitQuaternion, Vector3};

/// Readings of all sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorReadings {
    /// Time by the robot's clock, s.
    pub time: f64,
    /// Pose and motion of the base if they are known, from the simulation or motion capture.
    pub base: Option<FrameMotion>,
    /// Joint positions, rad or m.
    pub position: Vec<f64>,
    /// Joint velocities.
    pub velocity: Vec<f64>,
    /// Joint loads: the efforts of the actuators, N m or N.
    pub load: Vec<f64>,
    /// Orientation of the IMU (of the base without one), world from IMU.
    pub orientation: UnitQuaternion<f64>,
    /// Angular velocity of the IMU in its own axes, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// Specific force at the IMU's origin in its own axes, m/s^2: acceleration less gravity, at
    /// rest 9.81 upwards.
    pub specific_force: Vector3<f64>,
    /// Load on each sole, in the model's order; updated only in ticks at which a task needs
    /// [`super::Needs::LOADS`]. Zero at the first tick, when no forces are known yet.
    pub soles: Vec<SoleLoad>,
}

/// A point of a sole that touches, besides its vertices: a border of terrain or an object crosses the sole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoleCorner {
    /// Position, world, m.
    pub position: Vector3<f64>,
    /// Force on the sole, world axes, N.
    pub force: Vector3<f64>,
}

/// Force and moment on one sole, of the floor, terrain and objects that touch its link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SoleLoad {
    /// Force, world axes, N.
    pub force: Vector3<f64>,
    /// Mean of the force since the last tick, impacts included, world axes, N; only with an
    /// estimator that needs it.
    pub mean_force: Vector3<f64>,
    /// Moment about the centroid of the sole's vertices, world axes, N m.
    pub moment: Vector3<f64>,
    /// Whether `vertices`, `clamped` and `corners` are known. A force sensor measures only force and moment.
    pub resolved: bool,
    /// Force on each vertex, world axes, N.
    pub vertices: Vec<Vector3<f64>>,
    /// For each vertex: whether it sticks or slides.
    pub clamped: Vec<bool>,
    /// Other points of the link that stick or slide.
    pub corners: Vec<SoleCorner>,
}

impl SensorReadings {
    /// Points besides the vertices for which each sole has memory at the start.
    pub const CORNERS: usize = 8;

    /// Zero readings of the right sizes.
    pub fn blank(model: &Model) -> Self {
        let zero = vec![0.0; model.nj()];
        let sole = |k: usize| SoleLoad {
            vertices: vec![Vector3::zeros(); k],
            clamped: vec![false; k],
            corners: Vec::with_capacity(Self::CORNERS),
            ..SoleLoad::default()
        };
        SensorReadings {
            time: 0.0,
            base: None,
            position: zero.clone(),
            velocity: zero.clone(),
            load: zero,
            orientation: UnitQuaternion::identity(),
            angular_velocity: Vector3::zeros(),
            specific_force: Vector3::zeros(),
            soles: model.soles.iter().map(|s| sole(s.vertices.len())).collect(),
        }
    }
}
