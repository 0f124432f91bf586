//! Impulses of the floor on each sole between control ticks, for sensors that add up what they read.
//!
//! ```text
//! p_s = sum over steps of h (f_s(t) + f_s(t + h)) / 2 + impulses at instants
//! ```
//!
//! of second order in the step. The force at the start of a step is that after whatever has jumped there: the mean of what
//! two ticks read would miss every jump of the commands. Velocity-level steps know their impulse.

use super::plant::Plant;
use nalgebra::Vector3;

/// See the module. Floor axes.
#[derive(Clone, Debug)]
pub(super) struct Impulses {
    /// Since the last tick, N s.
    sum: Vec<Vector3<f64>>,
    /// Forces at the start of the step, N.
    begun: Vec<Vector3<f64>>,
}

impl Impulses {
    pub fn new(soles: usize) -> Self {
        Impulses { sum: vec![Vector3::zeros(); soles], begun: vec![Vector3::zeros(); soles] }
    }

    /// Impulses on the soles from now on are wrenches (6F) times `factor`.
    pub fn add(&mut self, wrenches: &[f64], factor: f64) {
        for (sum, w) in self.sum.iter_mut().zip(wrenches.chunks_exact(6)) {
            *sum += Vector3::new(w[0], w[1], w[2]) * factor;
        }
    }

    /// What sole `s` has got since the last call.
    pub fn take(&mut self, s: usize) -> Vector3<f64> {
        std::mem::take(&mut self.sum[s])
    }
}

impl Plant {
    /// Remembers the forces at the start of a step; needs an evaluation there.
    pub(super) fn begin_impulse(&mut self) {
        let Some(impulses) = &mut self.impulses else { return };
        for (begun, w) in impulses.begun.iter_mut().zip(self.solution.wrench.chunks_exact(6)) {
            *begun = Vector3::new(w[0], w[1], w[2]);
        }
    }

    /// Adds what the floor gave over a step of size `h`; needs an evaluation at its end.
    pub(super) fn end_impulse(&mut self, h: f64) {
        let Some(impulses) = &mut self.impulses else { return };
        impulses.add(&self.solution.wrench, 0.5 * h);
        for (sum, begun) in impulses.sum.iter_mut().zip(&impulses.begun) {
            *sum += begun * (0.5 * h);
        }
    }

    /// Adds those of a velocity-level step, which the solution holds.
    pub(super) fn take_step_impulse(&mut self) {
        if let Some(impulses) = &mut self.impulses {
            impulses.add(&self.solution.wrench, 1.0);
        }
    }

    /// Adds impulses of an instant.
    pub(super) fn add_impulse(&mut self, wrenches: &[f64]) {
        if let Some(impulses) = &mut self.impulses {
            impulses.add(wrenches, 1.0);
        }
    }
}
