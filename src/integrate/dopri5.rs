//! Dormand-Prince 5(4) with dense output of order 4.
//!
//! ```text
//! k_i = f(t + c_i h, y + h sum_j a_ij k_j)      y1 = y + h sum_j a_7j k_j      error = h sum_j e_j k_j
//! ```
//!
//! Source: Dormand and Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980), table 2;
//! dense output by Shampine as in Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
//! section II.6, equation 6.12 and its coefficients d_i.

use super::System;

const C: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
const A: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
const D: [f64; 7] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// One integrator's scratch; allocated once.
#[derive(Clone, Debug)]
pub struct Dopri5 {
    k: [Vec<f64>; 7],
    stage: Vec<f64>,
    /// Solution at the end of the last attempt.
    pub end: Vec<f64>,
    start: Vec<f64>,
    h: f64,
}

impl Dopri5 {
    /// For systems of `n` equations.
    pub fn new(n: usize) -> Self {
        Dopri5 {
            k: std::array::from_fn(|_| vec![0.0; n]),
            stage: vec![0.0; n],
            end: vec![0.0; n],
            start: vec![0.0; n],
            h: 0.0,
        }
    }

    /// Evaluates the derivative at the start of a step; needed before [`attempt`](Self::attempt) whenever t or y changed.
    pub fn begin(&mut self, system: &mut impl System, t: f64, y: &[f64]) {
        self.start.copy_from_slice(y);
        system.derivative(t, y, &mut self.k[0]);
    }

    /// Tries a step of size `h` from the point given to [`begin`](Self::begin): six evaluations, the last one at the
    /// end point. The result is in `end`; returns the largest component of the error estimate over
    /// `absolute + relative * max(|y|, |y1|)`, over the first `controlled` components.
    pub fn attempt(
        &mut self,
        system: &mut impl System,
        t: f64,
        h: f64,
        relative: f64,
        absolute: f64,
        controlled: usize,
    ) -> f64 {
        self.h = h;
        for s in 1..7 {
            let (done, rest) = self.k.split_at_mut(s);
            let target = if s == 6 { &mut self.end } else { &mut self.stage };
            for (i, (x, y)) in target.iter_mut().zip(&self.start).enumerate() {
                let mut sum = 0.0;
                for (a, k) in A[s].iter().zip(done.iter()) {
                    sum += a * k[i];
                }
                *x = y + h * sum;
            }
            system.derivative(t + C[s] * h, target, &mut rest[0]);
        }
        let mut worst: f64 = 0.0;
        for i in 0..controlled {
            let e: f64 = E.iter().zip(&self.k).map(|(e, k)| e * k[i]).sum();
            let scale = absolute + relative * self.start[i].abs().max(self.end[i].abs());
            worst = worst.max((h * e).abs() / scale);
            if !e.is_finite() {
                return f64::INFINITY;
            }
        }
        worst
    }

    /// Dense output at `t + theta h` of the last attempt, order 4.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        let rest = 1.0 - theta;
        for (i, y) in out.iter_mut().enumerate() {
            let difference = self.end[i] - self.start[i];
            let bulge = self.h * self.k[0][i] - difference;
            let skew = difference - self.h * self.k[6][i] - bulge;
            let d: f64 = D.iter().zip(&self.k).map(|(d, k)| d * k[i]).sum::<f64>() * self.h;
            *y = self.start[i] + theta * (difference + rest * (bulge + theta * (skew + rest * d)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn error(n: usize, dense: bool) -> f64 {
        let h = 2.0 / n as f64;
        let mut rk = Dopri5::new(2);
        let mut y = vec![0.0, 1.0];
        let mut worst: f64 = 0.0;
        for i in 0..n {
            let t = i as f64 * h;
            rk.begin(&mut Oscillator, t, &y);
            rk.attempt(&mut Oscillator, t, h, 1.0, 1.0, 2);
            if dense {
                let mut mid = [0.0; 2];
                rk.interpolate(0.37, &mut mid);
                worst = worst.max((mid[0] - exact(t + 0.37 * h)[0]).abs());
            }
            y.copy_from_slice(&rk.end);
        }
        if dense { worst } else { (y[0] - exact(2.0)[0]).abs().max((y[1] - exact(2.0)[1]).abs()) }
    }

    #[test]
    fn the_orders_are_five_and_four() {
        // Ratio of errors at half the step: 2^5 for the solution; the dense output's local error is of order 5 too
        // (order 4 globally), so it must fall at least by 2^4.
        let order = (error(20, false) / error(40, false)).log2();
        assert!((order - 5.0).abs() < 0.25, "{order}");
        let dense = (error(20, true) / error(40, true)).log2();
        assert!(dense > 4.0, "{dense}");
    }

    #[test]
    fn the_dense_output_meets_both_ends() {
        let mut rk = Dopri5::new(2);
        rk.begin(&mut Oscillator, 0.0, &[0.3, -0.2]);
        rk.attempt(&mut Oscillator, 0.0, 0.3, 1.0, 1.0, 2);
        let mut y = [0.0; 2];
        rk.interpolate(0.0, &mut y);
        assert_eq!(y, [0.3, -0.2]);
        rk.interpolate(1.0, &mut y);
        assert!((y[0] - rk.end[0]).abs() < 1e-15 && (y[1] - rk.end[1]).abs() < 1e-15);
    }
}
