//! A Rosenbrock-W method for equations with a stiff part of low rank.
//!
//! ```text
//! (1 - h g A) k_i = h f(t + a_i h, y + sum_j a_ij k_j) + h A sum_j<i g_ij k_j + h^2 g_i T      y1 = y + sum_i b_i k_i
//! A = N + sum_r u_r v_r^T      N N = 0      (1 - h g N)^-1 = 1 + h g N
//! (1 - h g A)^-1 x = (1 + h g N) (x + h g U S^-1 V^T (1 + h g N) x)      S = 1 - h g V^T (1 + h g N) U
//! ```
//!
//! N has the rates of positions by velocities, without which the stiffness of a spring would be explicit. T is the
//! derivative of the stiff part by time, such as of a servo whose command moves: without it the error of an inexact A
//! is a hundred times as high; `g_i = g + sum_j<i g_ij`.
//!
//! The method is ROS34PW2 of [Rang 2005]: four stages, order 3 with an embedded solution of order
//! 2, L-stable. Being a W-method it has order 3 with any matrix A, which for stability has to contain
//! what makes explicit steps unstable. Where that part of f is far from linear, the stages must not
//! leave the slow solution either: the rows must then have the whole change of what they measure
//! along the solution, so that `v_r^T f` is as small as that change. The dense output has order 2, and 3
//! where A is the Jacobian. Its weights are those of PETSc's TSROSWRA34PW2; unlike a Hermite interpolant it
//! does not use derivatives at the end of the step, in which stiffness amplifies errors.

use super::stiff_part::{StiffPart, sparse_dot};
use super::{System, error_norm};
use std::ops::Range;

const STAGES: usize = 4;
/// Diagonal coefficient g.
const GAMMA: f64 = 0.435_866_521_508_459;
const A: [[f64; 3]; STAGES] = [
    [0.0, 0.0, 0.0],
    [0.871_733_043_016_918, 0.0, 0.0],
    [0.844_570_600_153_694_2, -0.112_990_642_364_841_85, 0.0],
    [0.0, 0.0, 1.0],
];
const G: [[f64; 3]; STAGES] = [
    [0.0, 0.0, 0.0],
    [-0.871_733_043_016_918, 0.0, 0.0],
    [-0.903_380_570_130_440_8, 0.054_180_672_388_095_33, 0.0],
    [0.242_123_807_060_953_46, -1.223_250_583_904_514_7, 0.545_260_255_335_102_1],
];
const B: [f64; STAGES] =
    [0.242_123_807_060_953_46, -1.223_250_583_904_514_7, 1.545_260_255_335_102, 0.435_866_521_508_459];
/// Weights of the embedded solution of order 2.
const EMBEDDED: [f64; STAGES] = [0.378_109_031_458_193_7, -0.096_042_292_212_423_18, 0.5, 0.217_933_260_754_229_5];
/// Dense output: weights of the stages as polynomials in theta without constant term.
const DENSE: [[f64; 3]; STAGES] = [
    [1.056_429_845_579_409_4, -1.386_488_269_975_957_3, 0.572_182_231_457_501_6],
    [2.296_429_974_281_067, -8.262_611_700_275_677, 4.742_931_142_090_097],
    [-1.307_599_564_525_376, 7.250_979_895_056_055, -4.398_120_075_195_578],
    [-1.045_260_255_335_102, 2.398_120_075_195_581, -0.916_993_298_352_019_9],
];

/// The method with its scratch, allocated once.
#[derive(Clone, Debug)]
pub struct Rosenbrock {
    /// The stiff part for the steps from the last start.
    pub stiff: StiffPart,
    k: [Vec<f64>; STAGES],
    stage: Vec<f64>,
    slope: Vec<f64>,
    first: Vec<f64>,
    start: Vec<f64>,
    /// Solution at the end of the last attempt.
    pub end: Vec<f64>,
    /// Factorised S by rows, its pivots, and a right side.
    small: Vec<f64>,
    pivots: Vec<usize>,
    right: Vec<f64>,
    h: f64,
}

impl Rosenbrock {
    /// Allocates for systems of `n` equations with a stiff part of up to `rank` products.
    pub fn new(n: usize, rank: usize) -> Self {
        Rosenbrock {
            stiff: StiffPart::new(n, rank),
            k: std::array::from_fn(|_| vec![0.0; n]),
            stage: vec![0.0; n],
            slope: vec![0.0; n],
            first: vec![0.0; n],
            start: vec![0.0; n],
            end: vec![0.0; n],
            small: vec![0.0; rank * rank],
            pivots: vec![0; rank],
            right: vec![0.0; rank],
            h: 0.0,
        }
    }

    /// Makes room for a stiff part of `rank` products.
    pub fn reserve(&mut self, rank: usize) {
        if rank > self.right.len() {
            self.stiff.reserve(rank);
            self.small.resize(rank * rank, 0.0);
            self.pivots.resize(rank, 0);
            self.right.resize(rank, 0.0);
        }
    }

    /// Sets the start of a step and the derivative there; needed before
    /// [`attempt`](Self::attempt) whenever t or y changed. The stiff part is set by the caller.
    pub fn begin(&mut self, y: &[f64], slope: &[f64]) {
        self.start.copy_from_slice(y);
        self.first.copy_from_slice(slope);
    }

    /// Tries a step of size `h` and evaluates the system at its end. The result is in `end`.
    pub fn attempt(&mut self, system: &mut impl System, t: f64, h: f64) {
        self.h = h;
        self.factorize(h * GAMMA);
        for s in 0..STAGES {
            if s == 0 {
                self.slope.copy_from_slice(&self.first);
            } else {
                let (k, start) = (&self.k, &self.start);
                for (i, x) in self.stage.iter_mut().enumerate() {
                    *x = start[i] + (0..s).map(|j| A[s][j] * k[j][i]).sum::<f64>();
                }
                let c: f64 = A[s].iter().sum();
                system.derivative(t + c * h, &self.stage, &mut self.slope);
            }
            let (done, rest) = self.k.split_at_mut(s);
            let target = &mut rest[0];
            target.iter_mut().zip(&self.slope).for_each(|(x, f)| *x = h * f);
            for (j, k) in done.iter().enumerate().filter(|(j, _)| G[s][*j] != 0.0) {
                self.stiff.add_product(h * G[s][j], k, target);
            }
            let share = h * h * (GAMMA + G[s].iter().sum::<f64>());
            target.iter_mut().zip(&self.stiff.by_time).for_each(|(x, t)| *x += share * t);
            self.solve(s);
        }
        for i in 0..self.end.len() {
            self.end[i] = self.start[i] + (0..STAGES).map(|s| B[s] * self.k[s][i]).sum::<f64>();
        }
        system.derivative(t + h, &self.end, &mut self.slope);
    }

    /// Norm ([`error_norm`]) of the error estimate of the last attempt over groups of components,
    /// with relative and absolute tolerance.
    pub fn error(&self, tolerances: (f64, f64), groups: impl Iterator<Item = Range<usize>>) -> f64 {
        error_norm(groups, tolerances, [&self.start, &self.end], |i| {
            (0..STAGES).map(|s| (B[s] - EMBEDDED[s]) * self.k[s][i]).sum()
        })
    }

    /// Dense output at `t + theta h` of the last attempt.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        let weights = DENSE.map(|[a, b, c]| theta * (a + theta * (b + theta * c)));
        for (i, y) in out.iter_mut().enumerate() {
            *y = self.start[i] + (0..STAGES).map(|s| weights[s] * self.k[s][i]).sum::<f64>();
        }
    }

    /// Factorises S with row pivoting.
    fn factorize(&mut self, hg: f64) {
        let n = self.stiff.rank;
        for (i, ([direct, by_rates], x)) in self.stiff.products.iter().zip(&mut self.small).enumerate() {
            let unit = f64::from(i / n == i % n);
            *x = unit - hg * (direct + hg * by_rates);
        }
        for c in 0..n {
            let pivot = (c..n).max_by(|a, b| self.small[a * n + c].abs().total_cmp(&self.small[b * n + c].abs()));
            self.pivots[c] = pivot.unwrap_or(c);
            let (upper, lower) = self.small[..n * n].split_at_mut((c + 1) * n);
            let upper = &mut upper[c * n..];
            if self.pivots[c] > c {
                upper.swap_with_slice(&mut lower[(self.pivots[c] - c - 1) * n..][..n]);
            }
            for row in lower.chunks_exact_mut(n) {
                let factor = row[c] / upper[c];
                row[c] = factor;
                row[c + 1..].iter_mut().zip(&upper[c + 1..]).for_each(|(x, u)| *x -= factor * u);
            }
        }
    }

    /// Replaces k_s by `(1 - h g A)^-1 k_s`.
    fn solve(&mut self, s: usize) {
        let n = self.stiff.rank;
        let hg = self.h * GAMMA;
        let x = &mut self.k[s];
        // Positions of x + h g N x are those in which the rows see it.
        self.stiff.add_rates(hg, x);
        for r in 0..n {
            self.right[r] = sparse_dot(&self.stiff.rows[r], x);
        }
        for c in 0..n {
            self.right.swap(c, self.pivots[c]);
        }
        for r in 0..n {
            let row = &self.small[r * n..(r + 1) * n];
            let sum: f64 = row[..r].iter().zip(&self.right).map(|(l, x)| l * x).sum();
            self.right[r] -= sum;
        }
        for r in (0..n).rev() {
            let row = &self.small[r * n..(r + 1) * n];
            let sum: f64 = row[r + 1..].iter().zip(&self.right[r + 1..n]).map(|(u, x)| u * x).sum();
            self.right[r] = (self.right[r] - sum) / row[r];
        }
        let columns = self.right.iter().zip(&self.stiff.columns).take(n);
        if self.stiff.rates.is_empty() {
            for (weight, column) in columns {
                let weight = hg * weight;
                x.iter_mut().zip(column).for_each(|(x, u)| *x += weight * u);
            }
            return;
        }
        let change = &mut self.stage;
        change.fill(0.0);
        for (weight, column) in columns {
            change.iter_mut().zip(column).for_each(|(x, u)| *x += weight * u);
        }
        self.stiff.add_rates(hg, change);
        x.iter_mut().zip(change).for_each(|(x, change)| *x += hg * *change);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y0' = y1 + cos t, y1' = -y0 + c y1^2: not linear and not autonomous.
    struct Smooth;
    impl System for Smooth {
        fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
            dy[0] = y[1] + t.cos();
            dy[1] = -y[0] + 0.3 * y[1] * y[1];
        }
    }

    /// Prothero and Robinson: y' = l (y - sin t) + cos t, solution sin t.
    struct Prothero(f64);
    impl System for Prothero {
        fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
            dy[0] = self.0 * (y[0] - t.sin()) + t.cos();
        }
    }

    fn begin(method: &mut Rosenbrock, system: &mut impl System, t: f64, y: &[f64]) {
        let mut slope = y.to_vec();
        system.derivative(t, y, &mut slope);
        method.begin(y, &slope);
    }

    /// One product as the stiff part.
    fn set(method: &mut Rosenbrock, u: &[f64], v: &[f64]) {
        let (row, column) = method.stiff.add().unwrap();
        row.extend(v.iter().copied().enumerate());
        column.copy_from_slice(u);
        method.stiff.complete();
    }

    /// End after `n` steps over [0, 1], with any matrix of rank one as the stiff part, and the
    /// dense output in the middle of the first step.
    fn run(system: &mut impl System, y: &[f64], n: usize, u: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let mut method = Rosenbrock::new(y.len(), 1);
        set(&mut method, u, v);
        let mut y = y.to_vec();
        let mut middle = y.clone();
        let h = 1.0 / n as f64;
        for i in 0..n {
            begin(&mut method, system, i as f64 * h, &y);
            method.attempt(system, i as f64 * h, h);
            if i == 0 {
                method.interpolate(0.5, &mut middle);
            }
            y.copy_from_slice(&method.end);
        }
        (y, middle)
    }

    #[test]
    fn order_is_three_whatever_the_stiff_part() {
        // A unrelated to the Jacobian, which a Rosenbrock method that is no W-method would not
        // survive.
        let (u, v) = ([0.7, -1.3], [0.4, 0.9]);
        let truth = run(&mut Smooth, &[0.2, 0.5], 4096, &u, &v).0;
        let error = |n: usize| {
            let y = run(&mut Smooth, &[0.2, 0.5], n, &u, &v).0;
            (y[0] - truth[0]).abs().max((y[1] - truth[1]).abs())
        };
        let order = (error(32) / error(64)).log2();
        assert!((order - 3.0).abs() < 0.2, "{order}");
    }

    #[test]
    fn dense_output_is_of_order_two() {
        let (u, v) = ([0.7, -1.3], [0.4, 0.9]);
        let error = |n: usize| {
            let middle = run(&mut Smooth, &[0.2, 0.5], n, &u, &v).1;
            let h = 0.5 / n as f64;
            let mut fine = Rosenbrock::new(2, 1);
            let mut y = vec![0.2, 0.5];
            for i in 0..64 {
                let t = i as f64 * h / 64.0;
                begin(&mut fine, &mut Smooth, t, &y);
                fine.attempt(&mut Smooth, t, h / 64.0);
                y.copy_from_slice(&fine.end);
            }
            (y[0] - middle[0]).abs().max((y[1] - middle[1]).abs())
        };
        // One step: the order plus one.
        let order = (error(16) / error(32)).log2();
        assert!(order > 2.8, "{order}");
    }

    #[test]
    fn steps_far_beyond_the_stiff_time_scale_are_stable() {
        let rate = -1e8;
        let y = run(&mut Prothero(rate), &[0.0], 50, &[rate], &[1.0]).0;
        // The stiff part dominates: error far below that of h^3 = 8e-6.
        assert!((y[0] - 1f64.sin()).abs() < 1e-6, "{}", y[0] - 1f64.sin());
    }

    #[test]
    fn the_derivative_by_time_makes_up_for_an_inexact_stiff_part() {
        // 20 and 5 a step, of which the stiff part has 99 %.
        let error = |n: usize, uses_time: bool| {
            let (rate, h) = (-1e3, 1.0 / n as f64);
            let mut method = Rosenbrock::new(1, 1);
            let mut y = vec![0.0];
            for i in 0..n {
                let t = i as f64 * h;
                method.stiff.clear();
                set(&mut method, &[0.99 * rate], &[1.0]);
                if uses_time {
                    method.stiff.add_by_time(0, -t.cos());
                }
                begin(&mut method, &mut Prothero(rate), t, &y);
                method.attempt(&mut Prothero(rate), t, h);
                y.copy_from_slice(&method.end);
            }
            (y[0] - 1f64.sin()).abs()
        };
        assert!(50.0 * error(50, true) < error(50, false));
        let order = (error(50, true) / error(200, true)).log2() / 2.0;
        assert!(order > 2.3, "{order}");
    }

    /// A stiff attraction to y1 = sin y0, along a motion of y0; not linear at distances above
    /// `width`.
    struct Groove {
        rate: f64,
        width: f64,
    }
    impl System for Groove {
        fn derivative(&mut self, _: f64, y: &[f64], dy: &mut [f64]) {
            dy[0] = 1.0;
            let z = y[1] - y[0].sin();
            dy[1] = self.rate * (z + z.powi(3) / self.width.powi(2)) + y[0].cos();
        }
    }

    #[test]
    fn rows_with_the_whole_change_along_the_solution_keep_stages_near_it() {
        let (rate, start) = (-1e6, 0.3f64);
        let distance = |row: [f64; 2]| {
            let mut system = Groove { rate, width: 1e-3 };
            let mut method = Rosenbrock::new(2, 1);
            set(&mut method, &[0.0, rate], &row);
            begin(&mut method, &mut system, 0.0, &[start, start.sin()]);
            method.attempt(&mut system, 0.0, 0.01);
            (method.end[1] - method.end[0].sin()).abs()
        };
        // Curvature moves the stages off the solution by less than h^2 = 1e-4, a tenth of the width;
        // without y0 in the row they move by h, ten widths.
        let (whole, part) = (distance([-start.cos(), 1.0]), distance([0.0, 1.0]));
        assert!(whole < 1e-8 && part > 1.0, "{whole} {part}");
    }

    /// x'' = -w^2 (x - sin t) - 2 z w (x' - cos t) - sin t, solution sin t.
    struct Spring {
        w: f64,
        z: f64,
    }
    impl System for Spring {
        fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
            let damper = 2.0 * self.z * self.w * (y[1] - t.cos());
            (dy[0], dy[1]) = (y[1], -self.w * self.w * (y[0] - t.sin()) - damper - t.sin());
        }
    }

    /// Distance from sin t after `n` steps of 0.01 s, from 1e-3 off.
    fn springs_apart(spring: &mut Spring, rates: &[(usize, usize, f64)], n: usize) -> f64 {
        let mut method = Rosenbrock::new(2, 1);
        method.stiff.rates.extend_from_slice(rates);
        set(&mut method, &[0.0, -1.0], &[spring.w * spring.w, 2.0 * spring.z * spring.w]);
        let mut y = vec![1e-3, 1.0];
        for i in 0..n {
            let t = 0.01 * i as f64;
            begin(&mut method, spring, t, &y);
            method.attempt(spring, t, 0.01);
            y.copy_from_slice(&method.end);
        }
        (y[0] - (0.01 * n as f64).sin()).abs()
    }

    #[test]
    fn a_stiff_spring_is_damped_only_with_the_rates_of_its_positions() {
        // 1e3 radians a step. The method reduces the deviation at each step, as it is L-stable.
        let mut spring = Spring { w: 1e5, z: 0.0 };
        let with = springs_apart(&mut spring, &[(0, 1, 1.0)], 40);
        let without = springs_apart(&mut spring, &[], 40);
        assert!(with < 1e-7 && !(without < 1.0), "{with} {without}");
    }

    #[test]
    fn the_rate_bound_is_that_of_springs_and_dampers() {
        for (w, z) in [(100.0, 0.0), (100.0, 50.0)] {
            let mut method = Rosenbrock::new(2, 1);
            method.stiff.rates.push((0, 1, 1.0));
            set(&mut method, &[0.0, -1.0], &[w * w, 2.0 * z * w]);
            // The greater root of x^2 = 2 z w x + w^2, at most 1 + 1/(4 z^2) of the fastest eigenvalue.
            let bound = z * w + (z * z * w * w + w * w).sqrt();
            assert!((method.stiff.rate_bound() / bound - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn error_estimate_shrinks_with_the_third_power_of_the_step() {
        let estimate = |h: f64| {
            let mut method = Rosenbrock::new(2, 1);
            begin(&mut method, &mut Smooth, 0.0, &[0.2, 0.5]);
            method.attempt(&mut Smooth, 0.0, h);
            method.error((0.0, 1.0), [0..1, 1..2].into_iter())
        };
        let order = (estimate(0.02) / estimate(0.01)).log2();
        assert!((order - 3.0).abs() < 0.2, "{order}");
    }
}
