//! Backward differentiation formulas for smooth motion with a stiff part of low rank.
//!
//! With the last points y(x_0), y(x_1), ... (the latest first) and their divided differences D_j, a step from x_0
//! to t1 = x_0 + h at order k is
//!
//! ```text
//! P(t) = sum_j=0..k D_j prod_i<j (t - x_i)                       predictor, through the last k + 1 points
//! w = sum_i<k 1 / (t1 - x_i)
//! (w - A) d = f(t1, P(t1)) - P'(t1)      y1 = P(t1) + d
//! Q(t) = P(t) + d prod_i<k (t - x_i) / (t1 - x_i)                through y1 and the last k points
//! e_k = d h / (t1 - x_k)                                         error
//! ```
//!
//! These are the variable-coefficient formulas of [Hairer 1993], section III.5, with one Newton iteration from the
//! predictor. If A is the Jacobian and f linear, `Q'(t1) = f(t1, y1)`; otherwise the next iteration would change y1
//! by some `(df/dy - A) d / w`, which is of higher order, and [`correction`](Bdf::correction) gives it. A step
//! evaluates f once, where a Rosenbrock method of order 3 needs four evaluations, but the points must have no jump
//! between them.
//!
//! Sizes and orders are chosen as in [Brown 1989]: after k + 1 steps, or once the step has to be shorter, the one of
//! the orders k - 1, k and k + 1 that allows the longest step. Their errors are those at the latest point,
//!
//! ```text
//! e_q = D_(q+1) prod_i=0..q (x_0 - x_(i+1)) (x_0 - x_1) / (x_0 - x_(q+1))
//! ```
//!
//! Formulas of orders 1 and 2 are A-stable; those of 3 to 5 are stable in sectors of 86, 73 and 51 degrees on both
//! sides of the negative real axis. Oscillations outside grow until they are errors, which lower the order.

use super::{StiffSolver, System, error_norm};
use crate::math;
use std::ops::Range;

/// Highest order.
const MOST: usize = 5;
/// Number of points kept: an order needs one more than it, and its error one more.
const POINTS: usize = MOST + 2;
/// Number of points from which the method can begin.
const FIRST_POINTS: usize = 6;
/// Factors on the errors of orders k - 1, k and k + 1 in the choice of the next step.
const BIAS: [f64; 3] = [6.0, 6.0, 10.0];
/// Growth of the step from which size and order change.
const GROWTH: f64 = 1.2;
/// Growth of the step below which they change at once.
const SHRINKAGE: f64 = 0.9;
/// Least and greatest growth of a step.
const LEAST_GROWTH: f64 = 0.2;
const MOST_GROWTH: f64 = 2.0;
/// A step shorter than this part of the planned one was cut short.
const CUT: f64 = 0.8;

/// The method with its points and scratch, allocated once.
#[derive(Clone, Debug)]
pub struct Bdf {
    /// Times x_i of the points.
    times: [f64; POINTS],
    /// Divided differences D_j, of which as many are in use as there are points.
    differences: Vec<Vec<f64>>,
    points: usize,
    /// Order of the next step; zero before the first.
    order: usize,
    /// Size of the next step, s.
    size: f64,
    /// Steps since size or order changed.
    steps: usize,
    /// Steps since the first.
    taken: i32,
    /// Step of the last attempt, s, and its w.
    h: f64,
    w: f64,
    predictor: Vec<f64>,
    predicted_slope: Vec<f64>,
    slope: Vec<f64>,
    d: Vec<f64>,
    /// Solution at the end of the last attempt.
    pub end: Vec<f64>,
}

impl Bdf {
    /// Allocates for systems of `n` equations.
    pub fn new(n: usize) -> Self {
        Bdf {
            times: [0.0; POINTS],
            differences: vec![vec![0.0; n]; POINTS],
            points: 0,
            order: 0,
            size: 0.0,
            steps: 0,
            taken: 0,
            h: 0.0,
            w: 0.0,
            predictor: vec![0.0; n],
            predicted_slope: vec![0.0; n],
            slope: vec![0.0; n],
            d: vec![0.0; n],
            end: vec![0.0; n],
        }
    }

    /// Forgets all points, after a jump of the equations or of the solution.
    pub fn clear(&mut self) {
        (self.points, self.order, self.taken) = (0, 0, 0);
    }

    /// Adds the latest point of the solution.
    pub fn add_point(&mut self, t: f64, y: &[f64]) {
        if self.points > 0 && !(t > self.times[0]) {
            self.clear();
        }
        // The new differences of orders 0, 1, ... in turn.
        let new = &mut self.predictor;
        new.copy_from_slice(y);
        for j in 0..(self.points + 1).min(POINTS) {
            let inverse = if j < self.points { 1.0 / (t - self.times[j]) } else { 0.0 };
            for (new, d) in new.iter_mut().zip(&mut self.differences[j]) {
                let old = std::mem::replace(d, *new);
                *new = (*new - old) * inverse;
            }
        }
        self.times.copy_within(..POINTS - 1, 1);
        self.times[0] = t;
        self.points = (self.points + 1).min(POINTS);
        self.steps += 1;
        self.taken = self.taken.saturating_add(i32::from(self.order > 0));
    }

    /// Number of steps since the method has begun, which are among the latest points.
    pub fn taken(&self) -> i32 {
        self.taken
    }

    /// Whether the points suffice for a step.
    pub fn is_ready(&self) -> bool {
        // The errors of a step that was cut short say little.
        let [last, before] = [0, 1].map(|i| self.times[i] - self.times[i + 1]);
        self.order > 0 || self.points >= FIRST_POINTS && last >= CUT * before
    }

    /// Chooses order and size of the next step by the errors at the latest point, in units of the tolerance, and
    /// returns the size, s, at most `max_step`.
    pub fn plan<G: Iterator<Item = Range<usize>>>(
        &mut self,
        tolerances: (f64, f64),
        groups: impl Fn() -> G,
        max_step: f64,
    ) -> f64 {
        let last = self.times[0] - self.times[1];
        let most = (self.points - 2).min(MOST);
        let growth = |q: usize, bias: f64| {
            let products: f64 = (0..=q).map(|i| self.times[0] - self.times[i + 1]).product();
            let scale = products * last / (self.times[0] - self.times[q + 1]);
            let (y, d) = (&self.differences[0], &self.differences[q + 1]);
            let error = error_norm(groups(), tolerances, [y, y], |i| scale * d[i]);
            (q, math::powf(bias * error.max(1e-10), -1.0 / (q + 1) as f64))
        };
        let longer = |a: (usize, f64), b: (usize, f64)| if b.1 > a.1 { b } else { a };
        let (order, growth) = if self.order == 0 {
            (1..=most).map(|q| growth(q, BIAS[1])).fold((1, 0.0), longer)
        } else if last < CUT * self.size {
            // Its errors say little about a whole step.
            return self.size;
        } else {
            let k = self.order.min(most);
            let (present, is_due) = (growth(k, BIAS[1]), self.steps > k);
            let (mut best, holds) = (present, present.1 >= SHRINKAGE);
            if holds && !is_due {
                return self.size;
            }
            if k > 1 {
                best = longer(best, growth(k - 1, BIAS[0]));
            }
            if k < most && is_due {
                best = longer(best, growth(k + 1, BIAS[2]));
            }
            if holds && best.1 < GROWTH {
                return self.size;
            }
            best
        };
        let size = (last * growth.clamp(LEAST_GROWTH, MOST_GROWTH)).min(max_step);
        (self.order, self.size, self.steps) = (order, size, 0);
        size
    }

    /// Tries a step of size `h` from the latest point, with the stiff part of `solver`. The result is in `end`, where
    /// the system is not evaluated.
    pub fn attempt(&mut self, solver: &mut StiffSolver, system: &mut impl System, h: f64) {
        self.h = h;
        let t1 = self.times[0] + h;
        let k = self.order;
        self.predictor.copy_from_slice(&self.differences[0]);
        self.predicted_slope.fill(0.0);
        let (mut product, mut rate, mut w) = (1.0, 0.0, 0.0);
        for j in 1..=k {
            let distance = t1 - self.times[j - 1];
            (product, rate) = (product * distance, rate * distance + product);
            w += 1.0 / distance;
            let targets = self.predictor.iter_mut().zip(&mut self.predicted_slope);
            targets.zip(&self.differences[j]).for_each(|((p, s), d)| {
                *p += product * d;
                *s += rate * d;
            });
        }
        system.derivative(t1, &self.predictor, &mut self.slope);
        self.w = w;
        solver.factorize(1.0 / w);
        for ((d, f), s) in self.d.iter_mut().zip(&self.slope).zip(&self.predicted_slope) {
            *d = (f - s) / w;
        }
        solver.solve(&mut self.d);
        for ((end, p), d) in self.end.iter_mut().zip(&self.predictor).zip(&self.d) {
            *end = p + d;
        }
    }

    /// Norm ([`mod@error_norm`]) of the error estimate of the last attempt over groups of components,
    /// with relative and absolute tolerance.
    pub fn error(&self, tolerances: (f64, f64), groups: impl Iterator<Item = Range<usize>>) -> f64 {
        let scale = self.h / (self.times[0] + self.h - self.times[self.order]);
        error_norm(groups, tolerances, [&self.differences[0], &self.end], |i| scale * self.d[i])
    }

    /// Norm of the change of the end by another iteration, with the derivative at the end.
    pub fn correction(
        &mut self,
        solver: &mut StiffSolver,
        slope_at_end: impl FnOnce(&[f64], &mut [f64]),
        tolerances: (f64, f64),
        groups: impl Iterator<Item = Range<usize>>,
    ) -> f64 {
        slope_at_end(&self.end, &mut self.slope);
        for ((f, s), d) in self.slope.iter_mut().zip(&self.predicted_slope).zip(&self.d) {
            *f = (*f - s) / self.w - d;
        }
        solver.solve(&mut self.slope);
        error_norm(groups, tolerances, [&self.differences[0], &self.end], |i| self.slope[i])
    }

    /// Factor by which to shorten a step whose last attempt had an `error` of more than 1. The next step has that size.
    pub fn shorten(&mut self, error: f64) -> f64 {
        let factor = match error.is_finite() {
            true => (0.9 * math::powf(error, -1.0 / (self.order + 1) as f64)).clamp(LEAST_GROWTH, SHRINKAGE),
            false => LEAST_GROWTH,
        };
        (self.size, self.steps) = (factor * self.h, 0);
        factor
    }

    /// Dense output at `t + theta h` of the last attempt.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        let (t, t1) = (self.times[0] + theta * self.h, self.times[0] + self.h);
        out.copy_from_slice(&self.differences[0]);
        let (mut product, mut part) = (1.0, 1.0);
        for j in 1..=self.order {
            product *= t - self.times[j - 1];
            part *= (t - self.times[j - 1]) / (t1 - self.times[j - 1]);
            out.iter_mut().zip(&self.differences[j]).for_each(|(out, d)| *out += product * d);
        }
        out.iter_mut().zip(&self.d).for_each(|(out, d)| *out += part * d);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::test_systems::{Prothero, Smooth};
    use crate::integrate::{DOPRI5, RungeKutta};
    use std::iter::once;

    /// x'' = -w^2 (x - sin t) - sin t, solution sin t.
    struct Spring(f64);
    impl System for Spring {
        fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
            (dy[0], dy[1]) = (y[1], -self.0 * self.0 * (y[0] - t.sin()) - t.sin());
        }
    }

    /// The solution of `Smooth` at time `t`.
    fn truth(t: f64) -> Vec<f64> {
        let (mut y, steps) = (vec![0.2, 0.5], 400);
        let mut method = RungeKutta::new(&DOPRI5, 2);
        for i in 0..steps {
            let h = t / f64::from(steps);
            method.begin(&mut Smooth, f64::from(i) * h, &y);
            method.attempt(&mut Smooth, f64::from(i) * h, h);
            y.copy_from_slice(&method.end);
        }
        y
    }

    /// A solver with one product of a column and a row as the stiff part.
    fn solver(u: &[f64], v: &[f64]) -> StiffSolver {
        let mut solver = StiffSolver::new(u.len(), 1);
        let (row, column) = solver.stiff.add().unwrap();
        row.extend(v.iter().copied().enumerate());
        column.copy_from_slice(u);
        solver.stiff.complete();
        solver
    }

    fn all(n: usize) -> impl Fn() -> std::iter::Once<Range<usize>> {
        move || once(0..n)
    }

    /// The method of this order with exact points of `Smooth` before and at 0.5, spaced by `h` in turn longer and
    /// shorter.
    fn begun(order: usize, h: f64) -> Bdf {
        let mut method = Bdf::new(2);
        let back = (0..=order).rev().map(|i| i as f64 * h + 0.2 * h * (i % 2) as f64);
        back.for_each(|back| method.add_point(0.5 - back, &truth(0.5 - back)));
        method.order = order;
        method
    }

    // Related to the Jacobian by nothing but its size.
    const COLUMN: [f64; 2] = [0.7, -1.3];
    const ROW: [f64; 2] = [0.4, 0.9];

    #[test]
    fn a_step_has_the_error_of_its_order_whatever_the_stiff_part() {
        for order in 1..=MOST {
            let error = |h: f64| {
                let mut method = begun(order, h);
                method.attempt(&mut solver(&COLUMN, &ROW), &mut Smooth, h);
                let off = |(a, b): (&f64, &f64)| (a - b).abs();
                let found = method.end.iter().zip(&truth(0.5 + h)).map(off).fold(0.0, f64::max);
                // The estimate, of the equations, is that of the solution but for the factor of a single step.
                let estimate = method.error((0.0, 1.0), all(2)());
                assert!((0.2..5.0).contains(&(estimate / found)), "{order}: {estimate} {found}");
                found
            };
            let found = (error(0.04) / error(0.02)).log2();
            assert!((found - order as f64 - 1.0).abs() < 0.35, "{order}: {found}");
        }
    }

    #[test]
    fn dense_output_has_the_order_of_the_step() {
        for order in 1..=MOST {
            let error = |h: f64| {
                let mut method = begun(order, h);
                method.attempt(&mut solver(&COLUMN, &ROW), &mut Smooth, h);
                let mut middle = vec![0.0; 2];
                method.interpolate(0.4, &mut middle);
                middle.iter().zip(&truth(0.5 + 0.4 * h)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let found = (error(0.04) / error(0.02)).log2();
            assert!((found - order as f64 - 1.0).abs() < 0.35, "{order}: {found}");
        }
    }

    /// A run with error control from exact points. Returns the ends of steps and the greatest error.
    fn run(system: &mut impl System, solver: &mut StiffSolver, start: &[f64], tolerance: f64) -> (Vec<f64>, f64) {
        let n = start.len();
        let mut method = Bdf::new(n);
        let solution = |t: f64| [t.sin(), t.cos()];
        (0..FIRST_POINTS - 1).for_each(|i| method.add_point(1e-3 * i as f64, &solution(1e-3 * i as f64)[..n]));
        let mut t = 1e-3 * (FIRST_POINTS - 1) as f64;
        let mut y: Vec<f64> = solution(t)[..n].iter().zip(start).map(|(y, off)| y + off).collect();
        let (mut times, mut worst) = (Vec::new(), 0.0f64);
        while t < 2.0 && times.len() < 10_000 {
            method.add_point(t, &y);
            let mut h = method.plan((0.0, tolerance), all(n), 0.1);
            loop {
                method.attempt(solver, system, h);
                let error = method.error((0.0, tolerance), once(0..n));
                if error <= 1.0 {
                    break;
                }
                h *= method.shorten(error);
            }
            t += h;
            y.copy_from_slice(&method.end);
            times.push(t);
            worst = worst.max((y[0] - t.sin()).abs());
        }
        (times, worst)
    }

    #[test]
    fn steps_are_as_long_as_the_accuracy_allows_far_beyond_the_stiff_time_scale() {
        // Without a tenth of the stiff part each iteration leaves a tenth of the error, which lowers the order.
        for (part, most) in [(1.0, 120), (0.9, 1000)] {
            let (times, worst) = run(&mut Prothero(-1e6), &mut solver(&[-1e6 * part], &[1.0]), &[0.0], 1e-8);
            assert!(worst < 1e-8 && times.len() < most, "{part}: {} {worst}", times.len());
        }
    }

    #[test]
    fn a_stiff_oscillator_without_damping_does_not_grow() {
        // Up to 1e4 radians a step, on the imaginary axis, where formulas of orders 3 to 5 are not stable.
        for w in [1e2, 1e3, 1e5] {
            let mut solver = StiffSolver::new(2, 1);
            solver.stiff.rates.push((0, 1, 1.0));
            let (row, column) = solver.stiff.add().unwrap();
            row.push((0, w * w));
            column.copy_from_slice(&[0.0, -1.0]);
            solver.stiff.complete();
            let (times, worst) = run(&mut Spring(w), &mut solver, &[0.0, 0.0], 1e-6);
            assert!(worst < 1e-5 && times.len() < 3000, "{w}: {} {worst}", times.len());
        }
    }

    #[test]
    fn polynomials_of_the_order_are_met() {
        /// y' = 3 t^2 - 1.
        struct Cubic;
        impl System for Cubic {
            fn derivative(&mut self, t: f64, _: &[f64], dy: &mut [f64]) {
                dy[0] = 3.0 * t * t - 1.0;
            }
        }
        let cubic = |t: f64| t * t * t - t;
        let mut method = Bdf::new(1);
        [0.0, 0.1, 0.15, 0.3].iter().for_each(|t| method.add_point(*t, &[cubic(*t)]));
        method.order = 3;
        method.attempt(&mut solver(&[-3.0], &[2.0]), &mut Cubic, 0.2);
        let mut middle = [0.0];
        method.interpolate(0.3, &mut middle);
        // Rounding.
        assert!((method.end[0] - cubic(0.5)).abs() < 1e-14 && (middle[0] - cubic(0.36)).abs() < 1e-14);
        assert!(method.error((0.0, 1.0), once(0..1)) < 1e-14);
    }

    #[test]
    fn the_correction_is_the_change_by_another_iteration() {
        let rate = -200.0;
        let correction = |part: f64| {
            let mut method = Bdf::new(1);
            (0..5).for_each(|i| method.add_point(0.1 * f64::from(i), &[(0.1 * f64::from(i)).sin()]));
            method.order = 3;
            let mut solver = solver(&[part * rate], &[1.0]);
            method.attempt(&mut solver, &mut Prothero(rate), 0.1);
            let slope = |y: &[f64], dy: &mut [f64]| Prothero(rate).derivative(0.5, y, dy);
            let found = method.correction(&mut solver, slope, (0.0, 1.0), once(0..1));
            // (w - l) y1 = w P - P' + f(t1, 0), which the whole stiff part solves at once.
            let (w, d) = (method.w, method.d[0]);
            let p = method.end[0] - d;
            let solved = p + ((rate * (p - 0.5f64.sin()) + 0.5f64.cos()) - method.predicted_slope[0]) / (w - rate);
            let rest = (solved - method.end[0]).abs();
            // It takes the same part of what is left.
            assert!((found - rest * (w - rate) / (w - part * rate)).abs() < 1e-13, "{part}: {found} {rest}");
            found
        };
        assert!(correction(1.0) < 1e-14 && correction(0.5) > 1e-6);
    }

    #[test]
    fn a_point_that_is_not_later_begins_anew() {
        let mut method = begun(4, 0.1);
        method.add_point(0.5, &[0.0, 0.0]);
        assert!(method.points == 1 && !method.is_ready());
    }
}
