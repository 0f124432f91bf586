//! `inertial`: gyroscope and acceleration integrated.
//!
//! Over a period T between ticks k-1 and k, with the gyroscope's omega and the specific force f in
//! the axes of the IMU, the IMU's own orientation R, position p and velocity v follow
//!
//! ```text
//! R_k = R_{k-1} exp(T (omega_{k-1} + omega_k) / 2)        R_mid = R_{k-1} exp(T (omega_{k-1} + omega_k) / 4)
//! a = R_mid f_k + g        p_k = p_{k-1} + T v_{k-1} + T^2 a / 2        v_k = v_{k-1} + T a
//! ```
//!
//! and the base follows from the sensed joints between the two. This is of second order in T; `f_k`
//! is the mean over the period (see [`crate::sim::sensing::sensors`]), so that velocity changes at
//! impacts count. With `by_soles` the centre of mass is integrated instead, as [Hale 2008], section
//! II, integrates gyroscopes and force plates,
//!
//! ```text
//! a = F_k / m + g        F_k = mean over the period of the sum of the forces on the soles, impacts included
//! ```
//!
//! and the base follows from it and the joints; forces elsewhere are not measured. In both variants
//! errors of the readings accumulate.

use super::Imu;
use crate::dynamics::chain::FrameMotion;
use crate::dynamics::{State, Workspace, body, kinematics};
use crate::robot::Model;
use crate::task::SensorReadings;
use nalgebra::{UnitQuaternion, Vector3};

pub(super) struct Inertial {
    by_soles: bool,
    gravity: Vector3<f64>,
    mass: f64,
    imu: Imu,
    /// Motion of the IMU.
    frame: FrameMotion,
    /// Reading of the gyroscope at the last tick.
    omega: Vector3<f64>,
    /// Centre of mass and its velocity.
    com: Vector3<f64>,
    com_velocity: Vector3<f64>,
    ws: Workspace,
    /// The estimate with its base at the origin and at rest.
    relative: State,
}

impl Inertial {
    pub fn new(model: &Model, imu: Imu, gravity: Vector3<f64>, by_soles: bool) -> Self {
        let relative = State::home(model);
        Inertial {
            imu,
            frame: imu.motion(model, &relative),
            by_soles,
            gravity,
            mass: model.mass(),
            omega: Vector3::zeros(),
            com: Vector3::zeros(),
            com_velocity: Vector3::zeros(),
            ws: Workspace::new(model),
            relative,
        }
    }

    pub fn by_soles(&self) -> bool {
        self.by_soles
    }

    pub fn begin(&mut self, model: &Model, state: &State, sensed: &SensorReadings) {
        self.omega = sensed.angular_velocity;
        self.frame = self.imu.motion(model, state);
        let (c, u) = self.com_from_base(model, state);
        self.com = state.position + c;
        self.com_velocity = Vector3::from_column_slice(&state.v[..3]) + u;
    }

    /// Updates `out`, which holds the last estimate of the base and the present joint readings.
    pub fn update(&mut self, model: &Model, sensed: &SensorReadings, dt: f64, out: &mut State) {
        let mean = (self.omega + sensed.angular_velocity) * 0.5;
        self.omega = sensed.angular_velocity;
        let frame = &mut self.frame;
        let middle = frame.rotation * UnitQuaternion::from_scaled_axis(mean * (0.5 * dt));
        frame.rotation *= UnitQuaternion::from_scaled_axis(mean * dt);
        frame.rotation.renormalize();
        frame.omega = frame.rotation * sensed.angular_velocity;
        if !self.by_soles {
            let a = middle * sensed.specific_force + self.gravity;
            frame.position += frame.velocity * dt + a * (0.5 * dt * dt);
            frame.velocity += a * dt;
        }
        self.imu.base(model, out, &self.frame).write_base(out);
        if !self.by_soles {
            return;
        }
        let force: Vector3<f64> = sensed.soles.iter().map(|s| s.mean_force).sum();
        let a = force / self.mass + self.gravity;
        self.com += self.com_velocity * dt + a * (0.5 * dt * dt);
        self.com_velocity += a * dt;
        let (c, u) = self.com_from_base(model, out);
        out.position = self.com - c;
        out.v[..3].copy_from_slice((self.com_velocity - u).as_slice());
    }

    /// Centre of mass from the base's origin and its velocity relative to it, world axes.
    fn com_from_base(&mut self, model: &Model, state: &State) -> (Vector3<f64>, Vector3<f64>) {
        self.relative.copy_from(state);
        self.relative.position = Vector3::zeros();
        self.relative.v[..3].fill(0.0);
        kinematics::update(model, &self.relative, &mut self.ws);
        (body::center_of_mass(&self.ws), body::center_of_mass_velocity(&self.ws))
    }
}
