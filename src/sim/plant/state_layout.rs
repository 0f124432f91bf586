//! Layout of the integrator's vector: position 3, quaternion 4 (i, j, k, w), joints, velocities,
//! lagging actuators, energy flows.
//!
//! The quaternion is integrated as four numbers, `q' = 1/2 (omega, 0) q`, and normalised after
//! every step. The energy flows ([`EnergyFlows`]) are not under error control.
//!
//! Error control must not depend on where the world's x and y point. It therefore takes components
//! that a turn about the vertical mixes as one (`integrate::error_norm`): x and y of
//! position, velocity and angular velocity, and the pairs (i, j) and (k, w) of the quaternion, as a
//! turn by a is the product with (0, 0, sin a/2, cos a/2). Their norms are the sine and cosine of
//! half the tilt from the vertical.

use super::energy_flows::{EnergyFlows, FLOWS};
use crate::dynamics::State;
use crate::robot::Model;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::ops::Range;

/// Offsets into the vector.
#[derive(Clone, Copy, Debug)]
pub struct StateLayout {
    nj: usize,
    nv: usize,
    nb: usize,
    /// Lagging actuators.
    na: usize,
}

impl StateLayout {
    /// For this robot.
    pub fn new(model: &Model) -> Self {
        StateLayout { nj: model.nj(), nv: model.nv(), nb: model.nb(), na: model.lagging().count() }
    }

    /// Length of the vector.
    pub fn size(&self) -> usize {
        7 + self.nj + self.nv + self.na + FLOWS
    }

    /// Number of leading entries under error control.
    pub fn controlled(&self) -> usize {
        self.size() - FLOWS
    }

    /// Groups of entries whose norms do not change when the world is turned about the vertical;
    /// together all entries under error control.
    pub fn error_groups(&self) -> impl Iterator<Item = Range<usize>> {
        let velocities = self.velocities().start;
        let pose = [0..2, 2..3, 3..5, 5..7].into_iter();
        let base = self.base_velocity_groups().map(move |g| velocities + g.start..velocities + g.end);
        let single = |i: usize| i..i + 1;
        let rest = (velocities + self.nb..self.controlled()).map(single);
        pose.chain((7..velocities).map(single)).chain(base).chain(rest)
    }

    /// The same groups of the base's velocities, as degrees of freedom; none if it is fixed.
    pub fn base_velocity_groups(&self) -> impl Iterator<Item = Range<usize>> {
        [0..2, 2..3, 3..5, 5..6].into_iter().filter(|g| g.end <= self.nb)
    }

    /// Reads the energy flows.
    pub fn flows(&self, y: &[f64]) -> EnergyFlows {
        let mut flows = EnergyFlows::default();
        flows.0.copy_from_slice(&y[self.controlled()..]);
        flows
    }

    /// Reads a state; the quaternion is normalised.
    pub fn unpack(&self, t: f64, y: &[f64], state: &mut State) {
        state.time = t;
        state.position = Vector3::new(y[0], y[1], y[2]);
        state.rotation = UnitQuaternion::from_quaternion(Quaternion::new(y[6], y[3], y[4], y[5]));
        state.joints.copy_from_slice(&y[7..7 + self.nj]);
        state.v.copy_from_slice(&y[7 + self.nj..7 + self.nj + self.nv]);
        state.actuators.copy_from_slice(&y[self.controlled() - self.na..self.controlled()]);
    }

    /// Writes a state and the energy flows.
    pub fn pack(&self, state: &State, flows: &EnergyFlows, y: &mut [f64]) {
        y[..3].copy_from_slice(state.position.as_slice());
        y[3..7].copy_from_slice(state.rotation.coords.as_slice());
        y[7..7 + self.nj].copy_from_slice(&state.joints);
        y[7 + self.nj..7 + self.nj + self.nv].copy_from_slice(&state.v);
        y[self.controlled() - self.na..self.controlled()].copy_from_slice(&state.actuators);
        y[self.controlled()..].copy_from_slice(&flows.0);
    }

    /// Writes the derivative from velocities `v`, accelerations and powers. The caller fills the
    /// entries of [`StateLayout::actuators`].
    pub fn derivative(&self, y: &[f64], v: &[f64], acceleration: &[f64], powers: &EnergyFlows, dy: &mut [f64]) {
        self.configuration_rates(&Quaternion::new(y[6], y[3], y[4], y[5]), v, dy);
        dy[7 + self.nj..7 + self.nj + self.nv].copy_from_slice(acceleration);
        dy[self.controlled()..].copy_from_slice(&powers.0);
    }

    /// Writes the derivative of position, quaternion `q` and joints from velocities `v`.
    pub fn configuration_rates(&self, q: &Quaternion<f64>, v: &[f64], dy: &mut [f64]) {
        dy[..7].fill(0.0);
        if self.nb == 6 {
            dy[..3].copy_from_slice(&v[..3]);
            let omega = Quaternion::new(0.0, v[3], v[4], v[5]);
            dy[3..7].copy_from_slice((omega * q * 0.5).coords.as_slice());
        }
        dy[7..7 + self.nj].copy_from_slice(&v[self.nb..]);
    }

    /// The entries of position, quaternion and joints.
    pub fn configuration(&self) -> Range<usize> {
        0..7 + self.nj
    }

    /// The entries of velocities.
    pub fn velocities(&self) -> Range<usize> {
        7 + self.nj..7 + self.nj + self.nv
    }

    /// The entries of lagging actuators.
    pub fn actuators<'a>(&self, y: &'a mut [f64]) -> &'a mut [f64] {
        &mut y[self.controlled() - self.na..self.controlled()]
    }

    /// Sets the derivatives of a joint's position and velocity to zero.
    pub fn hold(&self, joint: usize, dy: &mut [f64]) {
        dy[7 + joint] = 0.0;
        dy[7 + self.nj + self.nb + joint] = 0.0;
    }
}
