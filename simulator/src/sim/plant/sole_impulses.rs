//! Impulses on each sole between control ticks, for sensors that integrate forces.
//!
//! ```text
//! p_s = sum over steps of h (f_s(t) + f_s(t + h)) / 2 + impulses at instants
//! ```
//!
//! of second order in the step, with the forces of [`super::sole_loads`]. The force at the start of a step
//! is that after any jump there; the mean of two readings would miss jumps of the commands.
//! Velocity-level steps compute their impulse directly.

use super::Plant;
use nalgebra::Vector3;

/// Impulses since the last tick, floor axes.
#[derive(Clone, Debug)]
pub struct SoleImpulses {
    /// Since the last tick, N s.
    sum: Vec<Vector3<f64>>,
    /// Forces at the start of the step, N.
    step_start: Vec<Vector3<f64>>,
    /// Scratch: present forces, N.
    forces: Vec<Vector3<f64>>,
}

impl SoleImpulses {
    /// Zero impulses on a number of soles.
    pub fn new(soles: usize) -> Self {
        let zero = vec![Vector3::zeros(); soles];
        SoleImpulses { sum: zero.clone(), step_start: zero, forces: Vec::with_capacity(soles) }
    }

    /// Adds `factor` times these forces on the soles.
    pub fn add(&mut self, forces: &[Vector3<f64>], factor: f64) {
        self.sum.iter_mut().zip(forces).for_each(|(sum, f)| *sum += f * factor);
    }

    /// Returns the impulse on sole `s` since the last call, N s.
    pub fn take(&mut self, s: usize) -> Vector3<f64> {
        std::mem::take(&mut self.sum[s])
    }
}

impl Plant {
    /// Adds `factor` times what these wrenches (6F) give on the soles.
    pub fn add_sole_impulses(&mut self, wrenches: &[f64], factor: f64) {
        let Some(mut impulses) = self.impulses.take() else { return };
        let mut forces = std::mem::take(&mut impulses.forces);
        self.sole_forces(wrenches, &mut forces);
        impulses.add(&forces, factor);
        impulses.forces = forces;
        self.impulses = Some(impulses);
    }

    /// Adds `factor` times the forces of the solution.
    pub fn add_present_forces(&mut self, factor: f64) {
        let wrenches = std::mem::take(&mut self.solution.wrench);
        self.add_sole_impulses(&wrenches, factor);
        self.solution.wrench = wrenches;
    }

    /// Stores the forces at the start of a step.
    pub fn begin_sole_impulses(&mut self) {
        let Some(mut impulses) = self.impulses.take() else { return };
        self.sole_forces(&self.solution.wrench, &mut impulses.step_start);
        self.impulses = Some(impulses);
    }

    /// Adds the impulses of a step of size `h` that ends with the present forces.
    pub fn end_sole_impulses(&mut self, h: f64) {
        self.add_present_forces(0.5 * h);
        let Some(impulses) = &mut self.impulses else { return };
        for (sum, start) in impulses.sum.iter_mut().zip(&impulses.step_start) {
            *sum += start * (0.5 * h);
        }
    }
}
