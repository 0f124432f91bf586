//! A Rosenbrock-W method for equations with a stiff part of low rank.
//!
//! ```text
//! (1 - h g A) k_i = h g f(t + a_i h, y + sum_j a_ij k_j) + sum_j<i c_ij k_j + h^2 g g_i T      y1 = y + sum_i b_i k_i
//! A = N + sum_r u_r v_r^T      N N = 0      (1 - h g N)^-1 = 1 + h g N
//! (1 - h g A)^-1 x = (1 + h g N) (x + h g U S^-1 V^T (1 + h g N) x)      S = 1 - h g V^T (1 + h g N) U
//! ```
//!
//! N has the rates of positions by velocities, without which the stiffness of a spring would be explicit. T is the
//! derivative of the stiff part by time, such as of a servo whose command moves: without it the error of an inexact A
//! is a hundred times as high. The k_i are the u_i of [Hairer 1996], section IV.7, which need no product with A; c_ij is
//! theirs times g.
//!
//! The method is ROS34PW2 of [Rang 2005]: four stages, order 3 with an embedded solution of order
//! 2, L-stable. Being a W-method it has order 3 with any matrix A, which for stability has to contain
//! what makes explicit steps unstable. Where that part of f is far from linear, the stages must not
//! leave the slow solution either: the rows must then have the whole change of what they measure
//! along the solution, so that `v_r^T f` is as small as that change. It is stiffly accurate: y1 is the argument of f in
//! the last stage plus k_4. The dense output has order 2, and 3 where A is the Jacobian. Its weights are those of PETSc's
//! TSROSWRA34PW2; unlike a Hermite interpolant it does not use derivatives at the end of the step, in which stiffness
//! amplifies errors.

use super::stiff_part::{StiffPart, sparse_dot};
use super::{System, error_norm};
use std::ops::Range;

const STAGES: usize = 4;
/// Diagonal coefficient g.
const GAMMA: f64 = 0.435_866_521_508_459;
/// Coefficients a_ij. The weights b_i of the end are those of the last stage, and 1.
const A: [[f64; 3]; STAGES] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [1.419_217_317_455_764_5, -0.259_232_211_672_969_7, 0.0],
    [4.184_760_482_319_16, -0.285_192_017_355_495_93, 2.294_280_360_279_042],
];
/// Times of the stages, a_i.
const TIMES: [f64; STAGES] = [0.0, 0.871_733_043_016_918, 0.731_579_957_788_852_4, 1.0];
/// Coefficients c_ij.
const C: [[f64; 3]; STAGES] = [
    [0.0, 0.0, 0.0],
    [-2.0, 0.0, 0.0],
    [-1.823_996_994_774_513_6, 0.124_305_652_566_720_09, 0.0],
    [-2.775_676_116_302_468, -2.961_983_662_554_789, 1.250_979_895_056_060_4],
];
/// Coefficients g_i.
const G: [f64; STAGES] = [GAMMA, -GAMMA, -0.413_333_376_233_886_5, 0.0];
/// Weights of the end less those of the embedded solution of order 2.
const ERROR: [f64; STAGES] = [0.277_749_947_647_967_9, -1.403_239_895_175_999_2, 1.772_630_127_667_551, 0.5];
/// Dense output: weights of the stages as polynomials in theta without constant term.
const DENSE: [[f64; 3]; STAGES] = [
    [0.832_659_023_154_385_1, 4.520_784_200_520_349, -1.168_682_741_355_571_6],
    [-1.461_621_337_124_655, -4.727_954_322_284_011_5, 5.904_383_642_053_173_5],
    [0.0, 9.752_939_685_168_17, -7.458_659_324_889_133],
    [-2.398_120_075_195_581, 5.501_959_790_112_12, -2.103_839_714_916_539],
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
    /// The factors of the transpose of S by rows, with the inverse diagonal of U, its pivots, and a right side.
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

    /// Tries a step of size `h`. The result is in `end`, where the system is not evaluated.
    pub fn attempt(&mut self, system: &mut impl System, t: f64, h: f64) {
        self.h = h;
        self.factorize(h * GAMMA);
        for s in 0..STAGES {
            let (done, rest) = self.k.split_at_mut(s);
            let k = &mut rest[0];
            if s == 0 {
                k.iter_mut().zip(&self.first).for_each(|(k, f)| *k = h * GAMMA * f);
            } else {
                combine(&self.start, &A[s], done, &mut self.stage);
                system.derivative(t + TIMES[s] * h, &self.stage, &mut self.slope);
                k.iter_mut().zip(&self.slope).for_each(|(k, f)| *k = h * GAMMA * f);
                for (c, done) in C[s].iter().zip(done) {
                    k.iter_mut().zip(done).for_each(|(k, done)| *k += c * *done);
                }
            }
            let share = h * h * GAMMA * G[s];
            k.iter_mut().zip(&self.stiff.by_time).for_each(|(k, t)| *k += share * t);
            if s == STAGES - 1 {
                self.end.copy_from_slice(&self.stage);
            }
            self.solve(s);
        }
        self.end.iter_mut().zip(&self.k[STAGES - 1]).for_each(|(y, k)| *y += k);
    }

    /// Norm ([`mod@error_norm`]) of the error estimate of the last attempt over groups of components,
    /// with relative and absolute tolerance.
    pub fn error(&self, tolerances: (f64, f64), groups: impl Iterator<Item = Range<usize>>) -> f64 {
        error_norm(groups, tolerances, [&self.start, &self.end], |i| (0..STAGES).map(|s| ERROR[s] * self.k[s][i]).sum())
    }

    /// Dense output at `t + theta h` of the last attempt.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        let weights = DENSE.map(|[a, b, c]| theta * (a + theta * (b + theta * c)));
        combine(&self.start, &weights, &self.k, out);
    }

    /// Factorises the transpose of S, `S^T = P L U`, so that solves add multiples of rows.
    fn factorize(&mut self, hg: f64) {
        let n = self.stiff.rank;
        let [direct, by_rates] = &self.stiff.products;
        for (r, (direct, by_rates)) in direct.chunks_exact(n.max(1)).zip(by_rates.chunks_exact(n.max(1))).enumerate() {
            for (c, (direct, by_rates)) in direct.iter().zip(by_rates).enumerate() {
                self.small[c * n + r] = -hg * (direct + hg * by_rates);
            }
            self.small[r * n + r] += 1.0;
        }
        for c in 0..n {
            let pivot = (c..n).max_by(|a, b| self.small[a * n + c].abs().total_cmp(&self.small[b * n + c].abs()));
            self.pivots[c] = pivot.unwrap_or(c);
            let (upper, lower) = self.small[..n * n].split_at_mut((c + 1) * n);
            let upper = &mut upper[c * n..];
            if self.pivots[c] > c {
                upper.swap_with_slice(&mut lower[(self.pivots[c] - c - 1) * n..][..n]);
            }
            let inverse = 1.0 / upper[c];
            for row in lower.chunks_exact_mut(n) {
                let factor = row[c] * inverse;
                row[c] = factor;
                row[c + 1..].iter_mut().zip(&upper[c + 1..]).for_each(|(x, u)| *x -= factor * u);
            }
            upper[c] = inverse;
        }
    }

    /// Replaces k_s by `(1 - h g A)^-1 k_s`.
    fn solve(&mut self, s: usize) {
        let n = self.stiff.rank;
        let hg = self.h * GAMMA;
        let x = &mut self.k[s];
        // Positions of x + h g N x are those in which the rows see it.
        self.stiff.add_rates(hg, x);
        for (right, row) in self.right.iter_mut().zip(&self.stiff.rows).take(n) {
            *right = sparse_dot(row, x);
        }
        // S = U^T L^T P^T.
        for r in 0..n {
            let (row, rest) = (&self.small[r * n..(r + 1) * n], &mut self.right[r..n]);
            let y = rest[0] * row[r];
            rest[0] = y;
            rest[1..].iter_mut().zip(&row[r + 1..]).for_each(|(x, u)| *x -= y * u);
        }
        for r in (0..n).rev() {
            let z = self.right[r];
            let row = &self.small[r * n..r * n + r];
            self.right[..r].iter_mut().zip(row).for_each(|(x, l)| *x -= z * l);
        }
        for c in (0..n).rev() {
            self.right.swap(c, self.pivots[c]);
        }
        if self.stiff.rates.is_empty() {
            self.stiff.add_columns(hg, &self.right, x);
            return;
        }
        let change = &mut self.stage;
        change.fill(0.0);
        self.stiff.add_columns(hg, &self.right, change);
        self.stiff.add_rates(hg, change);
        x.iter_mut().zip(change).for_each(|(x, change)| *x += *change);
    }
}

/// Writes `start` and the sum of vectors with their weights.
fn combine(start: &[f64], weights: &[f64], vectors: &[Vec<f64>], out: &mut [f64]) {
    out.copy_from_slice(start);
    for (weight, vector) in weights.iter().zip(vectors) {
        out.iter_mut().zip(vector).for_each(|(out, x)| *out += weight * x);
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
    fn solves_invert_the_matrix_of_several_products() {
        // Columns in different places, one zero, and rows that see the rates.
        let columns = [[0.0, 0.0, 0.3, -2.0, 0.0], [0.0, 0.0, 4.0, 0.0, 1.5], [0.0; 5], [0.0, 0.0, 0.0, 0.7, -3.0]];
        let rows = [[2.0, 0.0, -1.0, 0.0, 0.5], [0.0, -3.0, 0.0, 0.4, 0.0], [1.0; 5], [0.6, 0.0, 0.0, -9.0, 0.0]];
        let mut method = Rosenbrock::new(5, 4);
        // Not in the order of the rows.
        method.stiff.rates.extend([(1, 3, 0.8), (0, 2, 1.1), (1, 2, -0.4)]);
        let mut a = [[0.0; 5]; 5];
        method.stiff.rates.iter().for_each(|(to, from, value)| a[*to][*from] = *value);
        for (column, row) in columns.iter().zip(&rows) {
            let (entries, u) = method.stiff.add().unwrap();
            entries.extend(row.iter().copied().enumerate().filter(|(_, x)| *x != 0.0));
            u.copy_from_slice(column);
            for (i, u) in column.iter().enumerate() {
                a[i].iter_mut().zip(row).for_each(|(a, v)| *a += u * v);
            }
        }
        method.stiff.complete();
        method.h = 0.9;
        let hg = method.h * GAMMA;
        method.factorize(hg);
        let x = [0.3, -1.2, 2.0, 0.7, -0.1];
        method.k[0].copy_from_slice(&x);
        method.solve(0);
        let k = &method.k[0];
        for i in 0..5 {
            let product: f64 = a[i].iter().zip(k).map(|(a, k)| a * k).sum();
            // Rounding.
            assert!((k[i] - hg * product - x[i]).abs() < 1e-13, "{i}: {k:?}");
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
