//! Actuators whose effort follows what is asked as a first-order lag, such as hydraulic ones.
//!
//! ```text
//! T dz/dt = u - z                    z effort, u what the drive asks within its limits, T time constant
//! ```
//!
//! z is part of the state. A velocity-level step of size dt holds u, taken at the velocity of the step's end, and is exact
//! for that:
//!
//! ```text
//! z+ = z + (u - z) (1 - e^-x)        mean of z over the step = z + phi (u - z),   phi = 1 - (1 - e^-x) / x,   x = dt / T
//! ```
//!
//! At the start of a run the actuators hold what the first command asks of them.

use super::actuator;
use super::plant::Plant;

/// Part of the way to u that z goes within `x` time constants, and that its mean over that time has gone.
pub(super) fn shares(x: f64) -> (f64, f64) {
    let end = -(-x).exp_m1();
    // 1 - end / x cancels below: its series there, the first term left out is x^4 / 120.
    let mean = if x < 1e-3 { x * (0.5 - x * (1.0 / 6.0 - x / 24.0)) } else { 1.0 - end / x };
    (end, mean)
}

impl Plant {
    /// Puts the efforts of lagging actuators in the place of what is asked of them, which is kept. With a step size `servo`
    /// is their mean over the step.
    pub(super) fn lag_behind(&mut self, dt: Option<f64>) {
        for (i, &j) in self.lagging.iter().enumerate() {
            let z = self.state.actuators[i];
            self.asked[i] = (self.servo[j], self.drive_give[j]);
            let mean = dt.map_or(0.0, |dt| shares(dt / self.model.joints[j].lag).1);
            self.efforts[j] = z;
            self.servo[j] = z + mean * (self.asked[i].0 - z);
            self.drive_give[j] *= mean;
        }
    }

    /// Rates of the efforts of lagging actuators at the last evaluation.
    pub(super) fn lag_rates(&self) -> impl Iterator<Item = f64> {
        self.lagging
            .iter()
            .zip(&self.asked)
            .zip(&self.state.actuators)
            .map(|((&j, (u, _)), z)| (u - z) / self.model.joints[j].lag)
    }

    /// Lets the actuators follow over a velocity-level step of size `dt` that changed the velocity by `dv`.
    pub(super) fn lag_over(&mut self, dv: &[f64], dt: f64) {
        let nb = self.model.nb();
        for (i, &j) in self.lagging.iter().enumerate() {
            let (asked, gain) = self.asked[i];
            let u = asked - gain / dt * dv[nb + j];
            self.state.actuators[i] += shares(dt / self.model.joints[j].lag).0 * (u - self.state.actuators[i]);
        }
    }

    /// Fills lagging actuators with what the present command asks at the present state.
    pub(super) fn fill_actuators(&mut self) {
        let nb = self.model.nb();
        for (i, &j) in self.lagging.iter().enumerate() {
            let (q, qd) = (self.state.joints[j], self.state.v[nb + j]);
            self.state.actuators[i] = actuator::servo(&self.model.joints[j], j, q, qd, &self.command).0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shares_are_those_of_the_exponential() {
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
