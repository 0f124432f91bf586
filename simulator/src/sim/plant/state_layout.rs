//! Layout of the integrator's vector: configurations, velocities, lagging actuators, energy flows.
//!
//! Configurations, velocities and actuators are those of the robot, then of the objects in turn. A
//! configuration is position 3, quaternion 4 (i, j, k, w), joints. The quaternion is integrated as four
//! numbers, `q' = 1/2 (omega, 0) q`, and normalised after every step. The energy flows
//! ([`EnergyFlows`]) are not under error control.
//!
//! Error control must not depend on where the world's x and y point. It therefore takes components
//! that a turn about the vertical mixes as one (`integrate::error_norm`): x and y of
//! position, velocity and angular velocity, and the pairs (i, j) and (k, w) of the quaternion, as a
//! turn by a is the product with (0, 0, sin a/2, cos a/2). Their norms are the sine and cosine of
//! half the tilt from the vertical.

use super::energy_flows::{EnergyFlows, FLOWS};
use crate::dynamics::State;
use crate::robot::Model;
use nalgebra::{Quaternion, UnitQuaternion, Vector3, Vector4};
use std::ops::Range;
use std::sync::Arc;

/// Entries of one mechanism: of its configuration, velocities and lagging actuators.
#[derive(Clone, Debug)]
struct Part {
    nb: usize,
    configuration: Range<usize>,
    velocities: Range<usize>,
    actuators: Range<usize>,
}

/// Offsets into the vector. Cheap to clone.
#[derive(Clone, Debug)]
pub struct StateLayout {
    parts: Arc<[Part]>,
    /// See [`StateLayout::error_groups`].
    groups: Arc<[Range<usize>]>,
    controlled: usize,
}

impl StateLayout {
    /// For this robot and these objects.
    pub fn new<'a>(robot: &'a Model, objects: impl Iterator<Item = &'a Model>) -> Self {
        let models: Vec<&Model> = std::iter::once(robot).chain(objects).collect();
        let mut at = 0;
        let mut take = |number: usize| {
            at += number;
            at - number..at
        };
        let configurations: Vec<_> = models.iter().map(|model| take(7 + model.nj())).collect();
        let velocities: Vec<_> = models.iter().map(|model| take(model.nv())).collect();
        let actuators: Vec<_> = models.iter().map(|model| take(model.lagging().count())).collect();
        let entries = configurations.into_iter().zip(velocities).zip(actuators);
        let part = |(model, ((configuration, velocities), actuators)): (&&Model, _)| Part {
            nb: model.nb(),
            configuration,
            velocities,
            actuators,
        };
        let parts: Arc<[Part]> = models.iter().zip(entries).map(part).collect();
        let groups = error_groups(&parts).collect();
        StateLayout { parts, groups, controlled: at }
    }

    /// Length of the vector.
    pub fn size(&self) -> usize {
        self.controlled + FLOWS
    }

    /// Number of leading entries under error control.
    pub fn controlled(&self) -> usize {
        self.controlled
    }

    /// Groups of entries whose norms do not change when the world is turned about the vertical;
    /// together all entries under error control.
    pub fn error_groups(&self) -> impl Iterator<Item = Range<usize>> {
        self.groups.iter().cloned()
    }

    /// The same groups of the base velocities of mechanism `m`, as degrees of freedom of it; none if
    /// its base is fixed.
    pub fn base_velocity_groups(&self, m: usize) -> impl Iterator<Item = Range<usize>> {
        base_groups(self.parts[m].nb)
    }

    /// Reads the energy flows.
    pub fn flows(&self, y: &[f64]) -> EnergyFlows {
        let mut flows = EnergyFlows::default();
        flows.0.copy_from_slice(&y[self.controlled..]);
        flows
    }

    /// Writes the energy flows.
    pub fn pack_flows(&self, flows: &EnergyFlows, y: &mut [f64]) {
        y[self.controlled..].copy_from_slice(&flows.0);
    }

    /// Reads the state of mechanism `m`; the quaternion is normalised.
    pub fn unpack(&self, m: usize, t: f64, y: &[f64], state: &mut State) {
        let part = &self.parts[m];
        let q = &y[part.configuration.clone()];
        state.time = t;
        state.position = Vector3::new(q[0], q[1], q[2]);
        state.rotation = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
        state.joints.copy_from_slice(&q[7..]);
        state.v.copy_from_slice(&y[part.velocities.clone()]);
        state.actuators.copy_from_slice(&y[part.actuators.clone()]);
    }

    /// Writes the state of mechanism `m`.
    pub fn pack(&self, m: usize, state: &State, y: &mut [f64]) {
        let part = &self.parts[m];
        let q = &mut y[part.configuration.clone()];
        q[..3].copy_from_slice(state.position.as_slice());
        q[3..7].copy_from_slice(state.rotation.coords.as_slice());
        q[7..].copy_from_slice(&state.joints);
        y[part.velocities.clone()].copy_from_slice(&state.v);
        y[part.actuators.clone()].copy_from_slice(&state.actuators);
    }

    /// Writes the derivative of the configuration of mechanism `m` at `y`.
    pub fn configuration_derivative(&self, m: usize, y: &[f64], v: &[f64], dy: &mut [f64]) {
        let q = &y[self.parts[m].configuration.clone()];
        self.configuration_rates(m, &Quaternion::new(q[6], q[3], q[4], q[5]), v, dy);
    }

    /// Writes the derivative of position, quaternion `q` and joints of mechanism `m` from its
    /// velocities `v`.
    pub fn configuration_rates(&self, m: usize, q: &Quaternion<f64>, v: &[f64], dy: &mut [f64]) {
        let part = &self.parts[m];
        let rates = &mut dy[part.configuration.clone()];
        rates[..7].fill(0.0);
        if part.nb == 6 {
            rates[..3].copy_from_slice(&v[..3]);
            let omega = Quaternion::new(0.0, v[3], v[4], v[5]);
            rates[3..7].copy_from_slice((omega * q * 0.5).coords.as_slice());
        }
        rates[7..].copy_from_slice(&v[part.nb..]);
    }

    /// The rates of [`configuration_rates`](Self::configuration_rates) by velocities, as entries with row, column and
    /// value.
    pub fn configuration_rate_entries(&self, m: usize, q: &Quaternion<f64>, each: &mut dyn FnMut((usize, usize, f64))) {
        let part = &self.parts[m];
        let (x, v) = (part.configuration.start, part.velocities.start);
        if part.nb == 6 {
            (0..3).for_each(|k| each((x + k, v + k, 1.0)));
            for k in 0..3 {
                let omega = Quaternion::from_imag(Vector3::from_fn(|i, _| f64::from(i == k)));
                let rate = (omega * q * 0.5).coords;
                (0..4).for_each(|c| each((x + 3 + c, v + 3 + k, rate[c])));
            }
        }
        (0..part.velocities.len() - part.nb).for_each(|j| each((x + 7 + j, v + part.nb + j, 1.0)));
    }

    /// Adds the entries of a function of the configuration of mechanism `m`, with its derivatives by displacements
    /// along all velocities. Displacements by a change dq of the quaternion are `2 Im(dq q*)`.
    pub fn add_displacement_entries(
        &self,
        m: usize,
        q: &Quaternion<f64>,
        derivatives: &[f64],
        row: &mut Vec<(usize, f64)>,
    ) {
        let part = &self.parts[m];
        let first = self.velocities().start;
        let by = &derivatives[part.velocities.start - first..part.velocities.end - first];
        let x = part.configuration.start;
        let mut add = |i: usize, value: f64| {
            if value != 0.0 {
                row.push((x + i, value));
            }
        };
        if part.nb == 6 {
            (0..3).for_each(|k| add(k, by[k]));
            let turn = Vector3::new(by[3], by[4], by[5]);
            for c in 0..4 {
                let change = Quaternion::from_vector(Vector4::from_fn(|i, _| f64::from(i == c)));
                add(3 + c, 2.0 * (change * q.conjugate()).imag().dot(&turn));
            }
        }
        by[part.nb..].iter().enumerate().for_each(|(j, value)| add(7 + j, *value));
    }

    /// The entries of positions, quaternions and joints.
    pub fn configuration(&self) -> Range<usize> {
        0..self.velocities().start
    }

    /// The entries of velocities.
    pub fn velocities(&self) -> Range<usize> {
        self.parts[0].velocities.start..self.parts[self.parts.len() - 1].velocities.end
    }

    /// The first velocity of mechanism `m` among those of all.
    pub fn velocity_offset(&self, m: usize) -> usize {
        self.parts[m].velocities.start - self.parts[0].velocities.start
    }

    /// The entries of lagging actuators of mechanism `m`.
    pub fn actuators<'a>(&self, m: usize, y: &'a mut [f64]) -> &'a mut [f64] {
        &mut y[self.parts[m].actuators.clone()]
    }

    /// The entries of position and velocity of a joint of mechanism `m`.
    pub fn joint(&self, m: usize, joint: usize) -> (usize, usize) {
        let part = &self.parts[m];
        (part.configuration.start + 7 + joint, part.velocities.start + part.nb + joint)
    }

    /// The entry of a lagging actuator of mechanism `m`.
    pub fn actuator(&self, m: usize, actuator: usize) -> usize {
        self.parts[m].actuators.start + actuator
    }

    /// Sets the derivatives of the position and velocity of a joint of the robot to zero.
    pub fn hold(&self, joint: usize, dy: &mut [f64]) {
        dy[7 + joint] = 0.0;
        dy[self.parts[0].velocities.start + self.parts[0].nb + joint] = 0.0;
    }
}

/// See [`StateLayout::error_groups`].
fn error_groups(parts: &[Part]) -> impl Iterator<Item = Range<usize>> {
    let single = |i: usize| i..i + 1;
    let configurations = parts.iter().flat_map(move |part| {
        let first = part.configuration.start;
        let pose = [0..2, 2..3, 3..5, 5..7].into_iter().map(move |g: Range<usize>| first + g.start..first + g.end);
        pose.chain((first + 7..part.configuration.end).map(single))
    });
    let velocities = parts.iter().flat_map(move |part| {
        let first = part.velocities.start;
        let base = base_groups(part.nb).map(move |g| first + g.start..first + g.end);
        base.chain((first + part.nb..part.velocities.end).map(single))
    });
    let actuators = parts.iter().flat_map(move |part| part.actuators.clone().map(single));
    configurations.chain(velocities).chain(actuators)
}

fn base_groups(nb: usize) -> impl Iterator<Item = Range<usize>> {
    [0..2, 2..3, 3..5, 5..6].into_iter().filter(move |g| g.end <= nb)
}
