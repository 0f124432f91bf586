//! Actuators whose effort follows the servo's with a first-order lag, such as hydraulic ones.
//!
//! ```text
//! T dz/dt = u - z                    z effort, u servo effort within its limits, T time constant
//! ```
//!
//! z is part of the state. A velocity-level step of size dt holds u at its value for the velocity
//! of the step's end, and solves the equation exactly for it:
//!
//! ```text
//! z+ = z + (u - z) (1 - e^-x)        mean of z over the step = z + phi (u - z),   phi = 1 - (1 - e^-x) / x,   x = dt / T
//! ```
//!
//! At the start of a run z is the servo effort of the first command.

use super::Drives;
use crate::math;
use crate::robot::Model;
use crate::task::Command;

/// Fraction of the way to u that z covers within `x` time constants, and the mean of that fraction
/// over the time.
pub(super) fn shares(x: f64) -> (f64, f64) {
    let end = -math::exp_m1(-x);
    // 1 - end / x cancels for small x. The first omitted term of the series is x^4 / 120.
    let mean = if x < 1e-3 { x * (0.5 - x * (1.0 / 6.0 - x / 24.0)) } else { 1.0 - end / x };
    (end, mean)
}

impl Drives {
    /// Replaces the efforts of lagging actuators by their states `z` and stores the servo efforts
    /// as their input. With a step size `servo` becomes the mean over the step.
    pub(super) fn apply_lag(&mut self, model: &Model, z: &[f64], dt: Option<f64>) {
        for (i, &j) in self.lagging.iter().enumerate() {
            let z = z[i];
            self.lag_input[i] = (self.servo[j], self.implicit[j]);
            let mean = dt.map_or(0.0, |dt| shares(dt / model.joints[j].lag).1);
            self.efforts[j] = z;
            self.servo[j] = z + mean * (self.lag_input[i].0 - z);
            self.implicit[j] *= mean;
        }
        if let Some(dt) = dt.filter(|_| !self.coupled.is_empty() && !self.lagging.is_empty()) {
            self.lag_matrices(model, |j| {
                let lag = model.joints[j].lag;
                if lag > 0.0 { shares(dt / lag).1 } else { 1.0 }
            });
        }
    }

    /// Rates of the efforts `z` of lagging actuators at the last evaluation.
    pub fn lag_rates(&self, model: &Model, z: &[f64]) -> impl Iterator<Item = f64> {
        self.lagging.iter().zip(&self.lag_input).zip(z).map(|((&j, (u, _)), z)| (u - z) / model.joints[j].lag)
    }

    /// Advances the efforts `z` of lagging actuators over a velocity-level step of size `dt` that
    /// changed the joint velocities by `dv`.
    pub fn advance_lag(&self, model: &Model, dv: &[f64], dt: f64, z: &mut [f64]) {
        for (i, &j) in self.lagging.iter().enumerate() {
            let (input, gain) = self.lag_input[i];
            let u = input - gain / dt * dv[j] - self.coupled_input(model, j, dv) / dt;
            z[i] += shares(dt / model.joints[j].lag).0 * (u - z[i]);
        }
    }

    /// Sets the efforts `z` of lagging actuators to the servo efforts of `command` at positions `q`
    /// and velocities `qd`.
    pub fn fill_lag(&self, model: &Model, q: &[f64], qd: &[f64], command: &Command, z: &mut [f64]) {
        for (i, &j) in self.lagging.iter().enumerate() {
            z[i] = self.servo_at(model, j, command, |l| (q[l], qd[l]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_match_the_exponential_and_its_mean() {
        // phi has its series below 1e-3: both sides of the border agree with x/2 - x^2/6 + x^3/24.
        for x in [1e-9, 9.99e-4, 1.001e-3, 0.1, 1.0, 30.0] {
            let (end, mean) = shares(x);
            assert!((end - (1.0 - (-x).exp())).abs() < 1e-15);
            // Numerically by Simpson's rule on a grid fine enough for 1e-12.
            let n = 10_000;
            let f = |i: usize| 1.0 - (-(x * i as f64 / n as f64)).exp();
            let weight = |i: usize| {
                if i == 0 || i == n {
                    1.0
                } else if i % 2 == 1 {
                    4.0
                } else {
                    2.0
                }
            };
            let simpson: f64 = (0..=n).map(|i| weight(i) * f(i)).sum::<f64>() / (3.0 * n as f64);
            assert!((mean - simpson).abs() < 1e-12, "{x}: {mean} {simpson}");
        }
    }
}
