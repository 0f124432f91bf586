//! `kinematic`: the base from the soles that are static.
//!
//! The IMU and the sensed joints between IMU and base give the orientation R of the base and its
//! angular velocity omega. With these and the joints q, forward kinematics gives for each sole s
//! the vector `r_s(R, q)` from the base's origin to the centroid of its vertices and the velocity
//! `u_s(omega, q, q')` that the centroid has relative to it. A static sole has an anchor `a_s` in
//! the world, so
//!
//! ```text
//! p = sum w_s (a_s - r_s) / sum w_s        p' = - sum w_s u_s / sum w_s
//! ```
//!
//! The weight w_s of a sole is its load `max(0, -F_s . g/|g| - threshold)`, so that the estimate
//! does not jump when the robot takes a step; soles imposed as static have equal weights. The
//! anchor of a sole that becomes static is its position in the present estimate. With no sole
//! static the robot flies: its centre of mass falls, `c'' = g`, and the base follows from it, the
//! orientation and the joints.
//!
//! After [Hale 2008], section II: base orientation and joint angles combined with assumptions about
//! which feet are static. A sole that slides under load shifts the estimate.

use super::Imu;
use crate::dynamics::chain::FrameMotion;
use crate::dynamics::{State, Workspace, body, jacobian, kinematics};
use crate::robot::Model;
use crate::task::SensorReadings;
use nalgebra::Vector3;

pub(super) struct Kinematic {
    ws: Workspace,
    /// The estimate with its base at the origin and at rest.
    relative: State,
    imu: Imu,
    gravity: Vector3<f64>,
    /// Load above which a sole is static, N.
    threshold: f64,
    imposed: Option<Vec<bool>>,
    soles: Vec<SoleAnchor>,
    /// Centre of mass of the last estimate and its velocity.
    com: (Vector3<f64>, Vector3<f64>),
    /// Which soles are static.
    is_static: Vec<bool>,
}

#[derive(Clone, Copy, Default)]
struct SoleAnchor {
    anchor: Vector3<f64>,
    weight: f64,
    /// Centroid relative to the base's origin, world axes, and its velocity.
    r: Vector3<f64>,
    u: Vector3<f64>,
}

impl Kinematic {
    pub fn new(model: &Model, imu: Imu, gravity: Vector3<f64>, threshold: f64, imposed: Option<Vec<bool>>) -> Self {
        let n = model.soles.len();
        Kinematic {
            ws: Workspace::new(model),
            relative: State::home(model),
            imu,
            gravity,
            threshold,
            imposed,
            soles: vec![SoleAnchor::default(); n],
            com: (Vector3::zeros(), Vector3::zeros()),
            is_static: vec![false; n],
        }
    }

    pub fn static_soles(&self) -> &[bool] {
        &self.is_static
    }

    /// Anchors all soles at their positions in the known initial state.
    pub fn begin(&mut self, model: &Model, state: &State) {
        self.locate_soles(model, state);
        for sole in &mut self.soles {
            sole.anchor = state.position + sole.r;
        }
        self.is_static.fill(true);
        self.store_com(state);
    }

    /// Updates `out`, which holds the last estimate of the base and the present joint readings.
    pub fn update(&mut self, model: &Model, sensed: &SensorReadings, dt: f64, out: &mut State) {
        let rotation = sensed.orientation;
        // Only orientation and angular velocity of the IMU are measured.
        let (position, velocity) = (Vector3::zeros(), Vector3::zeros());
        let frame = FrameMotion { rotation, omega: rotation * sensed.angular_velocity, position, velocity };
        let base = self.imu.base(model, out, &frame);
        out.rotation = base.rotation;
        out.v[3..6].copy_from_slice(base.omega.as_slice());
        self.locate_soles(model, out);
        let up = -self.gravity.try_normalize(0.0).unwrap_or(-Vector3::z());
        for (s, sole) in self.soles.iter_mut().enumerate() {
            sole.weight = match &self.imposed {
                Some(imposed) => f64::from(u8::from(imposed[s])),
                None => (sensed.soles[s].force.dot(&up) - self.threshold).max(0.0),
            };
        }
        let weight = |(sole, is_static): (&SoleAnchor, &bool)| if *is_static { sole.weight } else { 0.0 };
        let total: f64 = self.soles.iter().zip(&self.is_static).map(weight).sum();
        let (mut position, mut rate) = (Vector3::zeros(), Vector3::zeros());
        if total > 0.0 {
            for (sole, _) in self.soles.iter().zip(&self.is_static).filter(|(_, is_static)| **is_static) {
                position += (sole.anchor - sole.r) * (sole.weight / total);
                rate -= sole.u * (sole.weight / total);
            }
        } else {
            let (com, com_velocity) = self.com;
            position = com + com_velocity * dt + self.gravity * (0.5 * dt * dt) - body::center_of_mass(&self.ws);
            rate = com_velocity + self.gravity * dt - body::center_of_mass_velocity(&self.ws);
        }
        for (sole, is_static) in self.soles.iter_mut().zip(&mut self.is_static) {
            let loaded = sole.weight > 0.0;
            if loaded && !*is_static {
                sole.anchor = position + sole.r;
            }
            *is_static = loaded;
        }
        if total == 0.0 && self.is_static.contains(&true) {
            // Landing: the base moves with the soles from this tick.
            let weight: f64 = self.soles.iter().map(|s| s.weight).sum();
            rate = -self.soles.iter().map(|s| s.u * (s.weight / weight)).sum::<Vector3<f64>>();
        }
        out.position = position;
        out.v[..3].copy_from_slice(rate.as_slice());
        self.store_com(out);
    }

    /// Stores the centre of mass of an estimate and its velocity. Needs
    /// [`locate_soles`](Self::locate_soles).
    fn store_com(&mut self, state: &State) {
        let velocity = Vector3::from_column_slice(&state.v[..3]);
        self.com =
            (state.position + body::center_of_mass(&self.ws), velocity + body::center_of_mass_velocity(&self.ws));
    }

    /// Computes positions and velocities of the soles relative to the base.
    fn locate_soles(&mut self, model: &Model, state: &State) {
        self.relative.copy_from(state);
        self.relative.position = Vector3::zeros();
        self.relative.v[..3].fill(0.0);
        kinematics::update(model, &self.relative, &mut self.ws);
        for (anchor, sole) in self.soles.iter_mut().zip(&model.soles) {
            anchor.r = self.ws.point(sole.link, &sole.centroid());
            anchor.u = jacobian::point_velocity(&self.ws, sole.link, &anchor.r);
        }
    }
}
