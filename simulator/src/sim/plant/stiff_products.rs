//! Columns and rows of the stiff part of a step: responses to a force, and what a force depends on.

use super::{EnergyFlows, Plant};
use crate::integrate::StiffPart;
use nalgebra::Quaternion;

/// What responses are compared with.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluation {
    /// Motions of the contact problem without wrenches.
    pub motions: Vec<f64>,
    /// Contact wrenches.
    pub wrenches: Vec<f64>,
    pub accelerations: Vec<f64>,
    pub powers: EnergyFlows,
}

impl Evaluation {
    /// Writes the change of accelerations and powers since, per unit of a force that has changed by `force`.
    pub fn write_change(&self, plant: &Plant, force: f64, out: &mut [f64]) {
        let accelerations = out[plant.layout.velocities()].iter_mut().zip(&plant.acceleration).zip(&self.accelerations);
        accelerations.for_each(|((to, after), before)| *to = (after - before) / force);
        let powers = out[plant.layout.controlled()..].iter_mut().zip(plant.powers().0).zip(self.powers.0);
        powers.for_each(|((to, after), before)| *to = (after - before) / force);
    }
}

/// Derivatives of a quantity by displacements along all velocities, by the velocities, and its rate where both are held:
/// a moving Jacobian changes the velocity of a point by `J' v`.
#[derive(Clone, Debug, Default)]
pub(super) struct Derivatives {
    pub by_displacement: Vec<f64>,
    pub by_velocity: Vec<f64>,
    pub by_time: f64,
}

impl Derivatives {
    /// Zeros for `nv` velocities.
    pub fn clear(&mut self, nv: usize) {
        for list in [&mut self.by_displacement, &mut self.by_velocity] {
            list.clear();
            list.resize(nv, 0.0);
        }
        self.by_time = 0.0;
    }

    /// Adds to the derivatives by velocity `c` and the displacement along it.
    pub fn add(&mut self, c: usize, by_displacement: f64, by_velocity: f64) {
        self.by_displacement[c] += by_displacement;
        self.by_velocity[c] += by_velocity;
    }
}

impl Plant {
    /// Writes the row of a product from the derivatives of what it depends on, and its derivative by time, with
    /// the motion of kinematic joints.
    pub(super) fn write_derivatives(&self, of: &mut Derivatives, product: usize, out: &mut StiffPart) {
        let (nb, mut by_time) = (self.model.nb(), of.by_time);
        for &j in self.kinematic_paths.joints() {
            let motion = self.kinematic_paths.at(j, self.state.time, self.within);
            let of_joint = |list: &mut Vec<f64>| std::mem::take(&mut list[nb + j]);
            by_time += of_joint(&mut of.by_displacement) * motion.qd + of_joint(&mut of.by_velocity) * motion.qdd;
        }
        let row = out.product(product).0;
        row.clear();
        let first = self.layout.velocities().start;
        let velocities = of.by_velocity.iter().enumerate().filter(|(_, x)| **x != 0.0);
        row.extend(velocities.map(|(c, x)| (first + c, *x)));
        for m in 0..=self.objects.list.len() {
            self.layout.add_displacement_entries(m, self.rotation(m), &of.by_displacement, row);
        }
        if by_time != 0.0 {
            out.add_by_time(product, by_time);
        }
    }

    /// The rates of all configurations but those of kinematic joints, as entries with row, column and value that are
    /// not in `out` yet.
    pub(super) fn configuration_rates(&self, out: &mut Vec<(usize, usize, f64)>) {
        let known = out.len();
        for m in 0..=self.objects.list.len() {
            self.layout.configuration_rate_entries(m, self.rotation(m), &mut |entry| {
                let is_known = out[..known].iter().any(|(row, _, _)| *row == entry.0);
                if !is_known {
                    out.push(entry);
                }
            });
        }
        for &j in self.kinematic_paths.joints() {
            let (q, _) = self.layout.joint(0, j);
            out.retain(|(row, _, _)| *row != q);
        }
    }

    fn rotation(&self, mechanism: usize) -> &Quaternion<f64> {
        match mechanism {
            0 => self.state.rotation.quaternion(),
            _ => self.objects.list[mechanism - 1].state.rotation.quaternion(),
        }
    }
}
