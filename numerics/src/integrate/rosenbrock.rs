//! A Rosenbrock-W method for equations with a stiff part of low rank.
//!
//! ```text
//! (1 - h g A) k_i = h g f(t + a_i h, y + sum_j a_ij k_j) + sum_j<i c_ij k_j + h^2 g g_i T      y1 = y + sum_i b_i k_i
//! ```
//!
//! A is a [`StiffPart`](super::StiffPart) with rows v_r. T is the derivative of the stiff part by time, such as of a servo whose command moves: without it the error of an inexact A
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

use super::{StiffSolver, System, error_norm};
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
    k: [Vec<f64>; STAGES],
    stage: Vec<f64>,
    slope: Vec<f64>,
    first: Vec<f64>,
    start: Vec<f64>,
    /// Solution at the end of the last attempt.
    pub end: Vec<f64>,
}

impl Rosenbrock {
    /// Allocates for systems of `n` equations.
    pub fn new(n: usize) -> Self {
        Rosenbrock {
            k: std::array::from_fn(|_| vec![0.0; n]),
            stage: vec![0.0; n],
            slope: vec![0.0; n],
            first: vec![0.0; n],
            start: vec![0.0; n],
            end: vec![0.0; n],
        }
    }

    /// Sets the start of a step and the derivative there; needed before
    /// [`attempt`](Self::attempt) whenever t or y changed.
    pub fn begin(&mut self, y: &[f64], slope: &[f64]) {
        self.start.copy_from_slice(y);
        self.first.copy_from_slice(slope);
    }

    /// Tries a step of size `h` with the stiff part of `solver`. The result is in `end`, where the system is not
    /// evaluated.
    pub fn attempt(&mut self, solver: &mut StiffSolver, system: &mut impl System, t: f64, h: f64) {
        solver.factorize(h * GAMMA);
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
            k.iter_mut().zip(&solver.stiff.by_time).for_each(|(k, t)| *k += share * t);
            if s == STAGES - 1 {
                self.end.copy_from_slice(&self.stage);
            }
            solver.solve(k);
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
    use crate::integrate::test_systems::{Prothero, Smooth};

    fn begin(method: &mut Rosenbrock, system: &mut impl System, t: f64, y: &[f64]) {
        let mut slope = y.to_vec();
        system.derivative(t, y, &mut slope);
        method.begin(y, &slope);
    }

    /// One product as the stiff part.
    fn set(solver: &mut StiffSolver, u: &[f64], v: &[f64]) {
        let (row, column) = solver.stiff.add().unwrap();
        row.extend(v.iter().copied().enumerate());
        column.copy_from_slice(u);
        solver.stiff.complete();
    }

    /// End after `n` steps over [0, 1], with any matrix of rank one as the stiff part, and the
    /// dense output in the middle of the first step.
    fn run(system: &mut impl System, y: &[f64], n: usize, u: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut method, mut solver) = (Rosenbrock::new(y.len()), StiffSolver::new(y.len(), 1));
        set(&mut solver, u, v);
        let mut y = y.to_vec();
        let mut middle = y.clone();
        let h = 1.0 / n as f64;
        for i in 0..n {
            begin(&mut method, system, i as f64 * h, &y);
            method.attempt(&mut solver, system, i as f64 * h, h);
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
            let mut fine = Rosenbrock::new(2);
            let mut y = vec![0.2, 0.5];
            for i in 0..64 {
                let t = i as f64 * h / 64.0;
                begin(&mut fine, &mut Smooth, t, &y);
                fine.attempt(&mut StiffSolver::new(2, 1), &mut Smooth, t, h / 64.0);
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
            let (mut method, mut solver) = (Rosenbrock::new(1), StiffSolver::new(1, 1));
            let mut y = vec![0.0];
            for i in 0..n {
                let t = i as f64 * h;
                solver.stiff.clear();
                set(&mut solver, &[0.99 * rate], &[1.0]);
                if uses_time {
                    solver.stiff.add_by_time(0, -t.cos());
                }
                begin(&mut method, &mut Prothero(rate), t, &y);
                method.attempt(&mut solver, &mut Prothero(rate), t, h);
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
            let (mut method, mut solver) = (Rosenbrock::new(2), StiffSolver::new(2, 1));
            set(&mut solver, &[0.0, rate], &row);
            begin(&mut method, &mut system, 0.0, &[start, start.sin()]);
            method.attempt(&mut solver, &mut system, 0.0, 0.01);
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
        let (mut method, mut solver) = (Rosenbrock::new(2), StiffSolver::new(2, 1));
        solver.stiff.rates.extend_from_slice(rates);
        set(&mut solver, &[0.0, -1.0], &[spring.w * spring.w, 2.0 * spring.z * spring.w]);
        let mut y = vec![1e-3, 1.0];
        for i in 0..n {
            let t = 0.01 * i as f64;
            begin(&mut method, spring, t, &y);
            method.attempt(&mut solver, spring, t, 0.01);
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
    fn error_estimate_shrinks_with_the_third_power_of_the_step() {
        let estimate = |h: f64| {
            let (mut method, mut solver) = (Rosenbrock::new(2), StiffSolver::new(2, 1));
            begin(&mut method, &mut Smooth, 0.0, &[0.2, 0.5]);
            method.attempt(&mut solver, &mut Smooth, 0.0, h);
            method.error((0.0, 1.0), [0..1, 1..2].into_iter())
        };
        let order = (estimate(0.02) / estimate(0.01)).log2();
        assert!((order - 3.0).abs() < 0.2, "{order}");
    }
}
