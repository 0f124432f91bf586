//! Base estimators: the base's pose and velocity from sensor readings.
//!
//! Both start from the true pose and velocity of the base. From then on they have no access to the
//! floor, external forces or the simulated base.

mod inertial;
mod kinematic;

use super::imu::Imu;
use crate::dynamics::State;
use crate::math;
use crate::robot::Model;
use crate::task::SensorReadings;
use inertial::Inertial;
use kinematic::Kinematic;
use nalgebra::{UnitQuaternion, Vector3};

/// An estimator and its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum EstimatorSetup {
    /// The simulated base; joints as sensed.
    Truth,
    /// See `kinematic.rs`.
    Kinematic {
        /// A sole is static while it carries more than this, N.
        load: f64,
        /// Soles that are static regardless of their loads; none: decided by the loads.
        soles: Option<Vec<bool>>,
    },
    /// See `inertial.rs`.
    Inertial {
        /// Whether accelerations come from the sole forces, not from the accelerometer.
        by_soles: bool,
    },
}

enum Kind {
    Truth,
    Kinematic(Box<Kinematic>),
    Inertial(Box<Inertial>),
}

/// An estimator and its estimate.
pub struct Estimator {
    kind: Kind,
    /// Base as estimated, joints as sensed, at the last tick.
    pub state: State,
    started: bool,
}

impl Estimator {
    /// Prepares an estimator for a mounting of the IMU; allocates all memory.
    pub fn new(setup: &EstimatorSetup, model: &Model, imu: Imu, gravity: Vector3<f64>) -> Self {
        let kind = match setup {
            EstimatorSetup::Truth => Kind::Truth,
            EstimatorSetup::Kinematic { load, soles } => {
                Kind::Kinematic(Box::new(Kinematic::new(model, imu, gravity, *load, soles.clone())))
            }
            EstimatorSetup::Inertial { by_soles } => {
                Kind::Inertial(Box::new(Inertial::new(model, imu, gravity, *by_soles)))
            }
        };
        Estimator { kind, state: State::home(model), started: false }
    }

    /// Does its estimate differ from the simulated state?
    pub fn estimates(&self) -> bool {
        !matches!(self.kind, Kind::Truth)
    }

    /// Does it integrate the forces on the soles?
    pub fn integrates_forces(&self) -> bool {
        matches!(&self.kind, Kind::Inertial(i) if i.by_soles())
    }

    /// The robot's state has jumped: the next tick is treated as the first.
    pub fn restart(&mut self) {
        self.started = false;
    }

    /// Updates the estimate with the readings of a tick. If they contain the base, it is copied at
    /// the first tick, and with [`EstimatorSetup::Truth`] at every tick.
    pub fn update(&mut self, model: &Model, sensed: &SensorReadings) {
        let nb = model.nb();
        let dt = sensed.time - self.state.time;
        let first = !std::mem::replace(&mut self.started, true);
        if let Some(base) = sensed.base.filter(|_| first || !self.estimates()) {
            base.write_base(&mut self.state);
        }
        self.state.time = sensed.time;
        self.state.joints.copy_from_slice(&sensed.position);
        self.state.v[nb..].copy_from_slice(&sensed.velocity);
        match &mut self.kind {
            Kind::Truth => {}
            Kind::Kinematic(k) if first => k.begin(model, &self.state),
            Kind::Kinematic(k) => k.update(model, sensed, dt, &mut self.state),
            Kind::Inertial(i) if first => i.begin(model, &self.state, sensed),
            Kind::Inertial(i) => i.update(model, sensed, dt, &mut self.state),
        }
    }

    /// For each sole: does the kinematic estimator take it as static? Empty for other estimators.
    pub fn static_soles(&self) -> &[bool] {
        match &self.kind {
            Kind::Kinematic(k) => k.static_soles(),
            _ => &[],
        }
    }

    /// Distance of the estimated base from the true one, m, and the angle between them, rad.
    pub fn error(&self, truth: &State) -> (f64, f64) {
        // The arc cosine would lose half the digits of a small angle.
        let turn: UnitQuaternion<f64> = self.state.rotation.inverse() * truth.rotation;
        let angle = 2.0 * math::atan2(turn.imag().norm(), turn.w.abs());
        ((self.state.position - truth.position).norm(), angle)
    }
}
