//! Impulses of the floor on each sole between control ticks, for sensors that integrate forces.
//!
//! ```text
//! p_s = sum over steps of h (f_s(t) + f_s(t + h)) / 2 + impulses at instants
//! ```
//!
//! of second order in the step. The force at the start of a step is that after any jump there; the
//! mean of two readings would miss jumps of the commands. Velocity-level steps compute their
//! impulse directly.

use nalgebra::Vector3;

/// Impulses since the last tick, floor axes.
#[derive(Clone, Debug)]
pub struct SoleImpulses {
    /// Since the last tick, N s.
    sum: Vec<Vector3<f64>>,
    /// Forces at the start of the step, N.
    step_start: Vec<Vector3<f64>>,
}

impl SoleImpulses {
    /// Zero impulses on a number of soles.
    pub fn new(soles: usize) -> Self {
        SoleImpulses { sum: vec![Vector3::zeros(); soles], step_start: vec![Vector3::zeros(); soles] }
    }

    /// Adds `factor` times the forces of the wrenches (6F).
    pub fn add(&mut self, wrenches: &[f64], factor: f64) {
        for (sum, w) in self.sum.iter_mut().zip(wrenches.chunks_exact(6)) {
            *sum += Vector3::new(w[0], w[1], w[2]) * factor;
        }
    }

    /// Returns the impulse on sole `s` since the last call, N s.
    pub fn take(&mut self, s: usize) -> Vector3<f64> {
        std::mem::take(&mut self.sum[s])
    }

    /// Stores the forces at the start of a step.
    pub fn begin_step(&mut self, wrenches: &[f64]) {
        for (start, w) in self.step_start.iter_mut().zip(wrenches.chunks_exact(6)) {
            *start = Vector3::new(w[0], w[1], w[2]);
        }
    }

    /// Adds the impulse of a step of size `h` that ends with these wrenches.
    pub fn end_step(&mut self, wrenches: &[f64], h: f64) {
        self.add(wrenches, 0.5 * h);
        for (sum, start) in self.sum.iter_mut().zip(&self.step_start) {
            *sum += start * (0.5 * h);
        }
    }
}
