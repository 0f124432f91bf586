//! Explicit Runge-Kutta methods with dense output, one step at a time.
//!
//! ```text
//! k_i = f(t + c_i h, y + h sum_j a_ij k_j)      y1 = y + h sum_j a_nj k_j      error = h sum_j e_j k_j
//! ```
//!
//! A method is a [`Tableau`]. Its last row contains the weights, so the last stage is evaluated at
//! the end of the step, and the system is left there. (That stage could be the first of the next
//! step, "first same as last". A projection changes the state between steps, so the stage is
//! evaluated again.)

use super::{System, error_norm};
use crate::math;
use std::ops::Range;

/// Coefficients of a method; the file of each cites its source.
#[derive(Debug, PartialEq)]
pub struct Tableau {
    /// Name in scenario files.
    pub name: &'static str,
    /// Order of the solution.
    pub order: u32,
    /// Order of the dense output.
    pub dense_order: u32,
    /// Times of the stages, fractions of the step.
    pub c: &'static [f64],
    /// Coefficients a_ij of each stage; the last row contains the weights of the solution.
    pub a: &'static [&'static [f64]],
    /// Weights of the error estimate; empty for a method without one.
    pub error: &'static [f64],
    /// Dense output between the ends of a step.
    pub dense: DenseOutput,
}

/// Dense output: the solution between the ends of a step.
#[derive(Debug, PartialEq)]
pub enum DenseOutput {
    /// Cubic Hermite interpolant of value and slope at both ends, of order 3.
    Hermite,
    /// The cubic plus `h theta^2 (1 - theta)^2 sum_i d_i k_i`, of order 4.
    Quartic(&'static [f64]),
}

/// A method with its scratch, allocated once.
#[derive(Clone, Debug)]
pub struct RungeKutta {
    tableau: &'static Tableau,
    k: Vec<Vec<f64>>,
    stage: Vec<f64>,
    /// Solution at the end of the last attempt.
    pub end: Vec<f64>,
    start: Vec<f64>,
    /// Error estimate of the last attempt, over h.
    estimate: Vec<f64>,
    h: f64,
}

impl RungeKutta {
    /// Allocates for systems of `n` equations.
    pub fn new(tableau: &'static Tableau, n: usize) -> Self {
        RungeKutta {
            tableau,
            k: vec![vec![0.0; n]; tableau.c.len()],
            stage: vec![0.0; n],
            end: vec![0.0; n],
            start: vec![0.0; n],
            estimate: vec![0.0; n],
            h: 0.0,
        }
    }

    /// Evaluates the derivative at the start of a step; needed before [`attempt`](Self::attempt)
    /// whenever t or y changed.
    pub fn begin(&mut self, system: &mut impl System, t: f64, y: &[f64]) {
        self.start.copy_from_slice(y);
        system.derivative(t, y, &mut self.k[0]);
    }

    /// As [`begin`](Self::begin), with the derivative that `write` gives.
    pub fn begin_with(&mut self, y: &[f64], write: impl FnOnce(&mut [f64])) {
        self.start.copy_from_slice(y);
        write(&mut self.k[0]);
    }

    /// Derivative at the start of the step.
    pub fn slope(&self) -> &[f64] {
        &self.k[0]
    }

    /// Tries a step of size `h` from the point given to [`begin`](Self::begin). Evaluates every
    /// stage but the first, the last at the end point. The result is in `end`.
    pub fn attempt(&mut self, system: &mut impl System, t: f64, h: f64) {
        self.h = h;
        let last = self.k.len() - 1;
        for s in 1..=last {
            let (done, rest) = self.k.split_at_mut(s);
            let target = if s == last { &mut self.end } else { &mut self.stage };
            weighted_sum(self.tableau.a[s], done, target);
            target.iter_mut().zip(&self.start).for_each(|(x, y)| *x = y + h * *x);
            system.derivative(t + self.tableau.c[s] * h, target, &mut rest[0]);
        }
        weighted_sum(self.tableau.error, &self.k, &mut self.estimate);
    }

    /// Norm ([`mod@error_norm`]) of the error estimate of the last attempt over groups of components,
    /// with relative and absolute tolerance; zero for a method without an estimate.
    pub fn error(&self, tolerances: (f64, f64), groups: impl Iterator<Item = Range<usize>>) -> f64 {
        error_norm(groups, tolerances, [&self.start, &self.end], |i| self.h * self.estimate[i])
    }

    /// Estimate of the greatest modulus of an eigenvalue along the last attempt, 1/s, from the first `n` components of
    /// the two last stages, where both are at the end of the step ([Hairer 1996], section IV.2).
    pub fn rate_estimate(&self, n: usize) -> Option<f64> {
        let last = self.k.len() - 1;
        if self.tableau.c[last - 1] != self.tableau.c[last] {
            return None;
        }
        let (mut slopes, mut distance) = (0.0, 0.0);
        for i in 0..n {
            let difference = self.tableau.a[last].iter().zip(self.k.iter()).map(|(a, k)| a * k[i]).sum::<f64>();
            let before = self.tableau.a[last - 1].iter().zip(self.k.iter()).map(|(a, k)| a * k[i]).sum::<f64>();
            slopes += math::powi(self.k[last][i] - self.k[last - 1][i], 2);
            distance += math::powi(self.h * (difference - before), 2);
        }
        (distance > 0.0).then(|| (slopes / distance).sqrt())
    }

    /// Dense output at `t + theta h` of the last attempt.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        let rest = 1.0 - theta;
        let slope = &self.k[self.k.len() - 1];
        for (i, y) in out.iter_mut().enumerate() {
            let difference = self.end[i] - self.start[i];
            let bulge = self.h * self.k[0][i] - difference;
            let skew = difference - self.h * slope[i] - bulge;
            let quartic = match self.tableau.dense {
                DenseOutput::Hermite => 0.0,
                DenseOutput::Quartic(d) => d.iter().zip(&self.k).map(|(d, k)| d * k[i]).sum::<f64>() * self.h,
            };
            *y = self.start[i] + theta * (difference + rest * (bulge + theta * (skew + rest * quartic)));
        }
    }
}

/// `out = sum_j weights_j k_j`, summed from the first on. A run of components stays in registers.
fn weighted_sum(weights: &[f64], k: &[Vec<f64>], out: &mut [f64]) {
    const RUN: usize = 8;
    let (runs, rest) = out.as_chunks_mut::<RUN>();
    let first_of_rest = RUN * runs.len();
    for (r, run) in runs.iter_mut().enumerate() {
        let mut sum = [0.0; RUN];
        for (weight, k) in weights.iter().zip(k) {
            let k = &k[RUN * r..][..RUN];
            sum.iter_mut().zip(k).for_each(|(sum, k)| *sum += weight * k);
        }
        *run = sum;
    }
    for (i, x) in rest.iter_mut().enumerate().map(|(i, x)| (first_of_rest + i, x)) {
        *x = weights.iter().zip(k).fold(0.0, |sum, (weight, k)| sum + weight * k[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{BS23, DOPRI5, RK4};

    struct Oscillator;
    impl System for Oscillator {
        fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
            dy[0] = y[1] + t.cos();
            dy[1] = -y[0];
        }
    }

    /// y'' = -y + ..., y(0) = (0, 1): y0 = sin t + (t cos t + sin t) / 2, y1 = cos t - t sin t / 2.
    fn exact(t: f64) -> [f64; 2] {
        [t.sin() + 0.5 * (t * t.cos() + t.sin()), t.cos() - 0.5 * t * t.sin()]
    }

    fn apart(y: &[f64], t: f64) -> f64 {
        let truth = exact(t);
        (y[0] - truth[0]).abs().max((y[1] - truth[1]).abs())
    }

    /// Errors after `n` steps to t = 2 at its end, greatest within a step that starts from the
    /// truth, and of the estimate.
    fn errors(tableau: &'static Tableau, n: usize) -> [f64; 3] {
        let h = 2.0 / n as f64;
        let mut rk = RungeKutta::new(tableau, 2);
        let mut y = vec![0.0, 1.0];
        let (mut within, mut estimate): (f64, f64) = (0.0, 0.0);
        for i in 0..n {
            let t = i as f64 * h;
            rk.begin(&mut Oscillator, t, &exact(t));
            rk.attempt(&mut Oscillator, t, h);
            for theta in [0.2, 0.37, 0.5, 0.8] {
                let mut mid = [0.0; 2];
                rk.interpolate(theta, &mut mid);
                within = within.max(apart(&mid, t + theta * h));
            }
            rk.begin(&mut Oscillator, t, &y);
            rk.attempt(&mut Oscillator, t, h);
            estimate = estimate.max(rk.error((0.0, 1.0), [0..1, 1..2].into_iter()));
            y.copy_from_slice(&rk.end);
        }
        [apart(&y, 2.0), within, estimate]
    }

    #[test]
    fn errors_have_the_orders_of_the_method() {
        for tableau in [&DOPRI5, &BS23, &RK4] {
            let (coarse, fine) = (errors(tableau, 40), errors(tableau, 80));
            let order = |i: usize| (coarse[i] / fine[i]).log2();
            let whole = f64::from(tableau.order);
            // The next order is h = 1/20 smaller.
            assert!((order(0) - whole).abs() < 0.15, "{}: {}", tableau.name, order(0));
            // Within one step the error is of the order plus one.
            let dense = f64::from(tableau.dense_order) + 1.0;
            assert!((order(1) - dense).abs() < 0.25, "{} within: {}", tableau.name, order(1));
            if !tableau.error.is_empty() {
                // The estimate is the error of the lower method in one step.
                assert!((order(2) - whole).abs() < 0.25, "{} estimate: {}", tableau.name, order(2));
            } else {
                assert_eq!(fine[2], 0.0);
            }
        }
    }

    #[test]
    fn rows_sum_to_their_times_and_weights_to_one() {
        for tableau in [&DOPRI5, &BS23, &RK4] {
            assert_eq!(tableau.a.len(), tableau.c.len());
            for (row, c) in tableau.a.iter().zip(tableau.c) {
                assert!((row.iter().sum::<f64>() - c).abs() < 1e-14, "{}", tableau.name);
            }
            assert!(tableau.error.iter().sum::<f64>().abs() < 1e-15, "{}", tableau.name);
        }
    }

    #[test]
    fn the_dense_output_meets_both_ends_with_their_slopes() {
        for tableau in [&DOPRI5, &BS23, &RK4] {
            let mut rk = RungeKutta::new(tableau, 2);
            rk.begin(&mut Oscillator, 0.0, &[0.3, -0.2]);
            rk.attempt(&mut Oscillator, 0.0, 0.3);
            let at = |theta: f64| {
                let mut y = [0.0; 2];
                rk.interpolate(theta, &mut y);
                y
            };
            assert_eq!(at(0.0), [0.3, -0.2]);
            let y = at(1.0);
            assert!((y[0] - rk.end[0]).abs() < 1e-15 && (y[1] - rk.end[1]).abs() < 1e-15);
            // One-sided difference over 1e-6 of the step: curvature leaves about 1e-6.
            for (theta, k) in [(0.0, &rk.k[0]), (1.0, &rk.k[rk.k.len() - 1])] {
                let inside = if theta == 0.0 { 1e-6 } else { -1e-6 };
                let slope = (at(theta + inside)[0] - at(theta)[0]) / (inside * 0.3);
                assert!((slope - k[0]).abs() < 1e-5, "{} {slope} {}", tableau.name, k[0]);
            }
        }
    }
}
