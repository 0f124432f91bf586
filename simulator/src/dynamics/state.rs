//! Mechanical state of a robot: configuration, velocity, and the efforts of actuators with lag.

use crate::robot::Model;
use nalgebra::{UnitQuaternion, Vector3};

/// Configuration, velocity and actuator efforts at one time: the mechanical state of a run.
#[derive(Clone, PartialEq, Debug)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Origin of the root link in the world, m. Constant for a fixed base.
    pub position: Vector3<f64>,
    /// Orientation of the root link, world from link. Constant for a fixed base.
    pub rotation: UnitQuaternion<f64>,
    /// Joint positions, rad or m, one per joint.
    pub joints: Vec<f64>,
    /// Velocities `[p' (world), omega (world), joint rates]`, length `nv`.
    pub v: Vec<f64>,
    /// Efforts of actuators with lag, N m or N, in the order of [`Model::lagging`].
    pub actuators: Vec<f64>,
}

impl State {
    /// State at rest in the home posture at time 0, with the root upright at the world's origin.
    pub fn home(model: &Model) -> Self {
        State {
            time: 0.0,
            position: Vector3::zeros(),
            rotation: UnitQuaternion::identity(),
            joints: model.home.clone(),
            v: vec![0.0; model.nv()],
            actuators: vec![0.0; model.lagging().count()],
        }
    }

    /// Velocities of the joints, rad/s or m/s.
    pub fn rates(&self) -> &[f64] {
        &self.v[self.v.len() - self.joints.len()..]
    }

    /// Copies `other`, a state of the same model, without allocating.
    pub fn copy_from(&mut self, other: &State) {
        self.time = other.time;
        self.position = other.position;
        self.rotation = other.rotation;
        self.joints.copy_from_slice(&other.joints);
        self.v.copy_from_slice(&other.v);
        self.actuators.copy_from_slice(&other.actuators);
    }

    /// Moves the configuration by `d`, of length `nv` and laid out as `v`: base translation (world,
    /// m), base rotation vector (world, rad), joint displacements. `displace(v dt)` moves it
    /// for dt at constant `v`.
    pub fn displace(&mut self, d: &[f64]) {
        let nb = d.len() - self.joints.len();
        if nb == 6 {
            self.position += Vector3::new(d[0], d[1], d[2]);
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(d[3], d[4], d[5]));
            self.rotation = turn * self.rotation;
            // Rounding of quaternion products would accumulate.
            self.rotation.renormalize();
        }
        for (q, d) in self.joints.iter_mut().zip(&d[nb..]) {
            *q += d;
        }
    }
}
