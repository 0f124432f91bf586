//! Minimum-jerk curves through knots.
//!
//! ```text
//! q(t_i) = q_i,    integral of q'''(t)^2 dt least
//! ```
//!
//! The minimiser is a quintic between knots with four continuous derivatives everywhere (its first
//! variation leaves `q^(6) = 0` between knots and continuous q''' and q'''' at them). Sources: [de
//! Boor 1968], for natural splines of any order; the two-knot case is the path of [Flash 1985].
//!
//! Unknown are the velocities v_i and accelerations a_i at the knots. On an interval of length h,
//! with `u = (q0, h v0, h^2 a0, q1, h v1, h^2 a1)`, the integral is `u^T K u / h^5` with the matrix
//! K below, so the sum over all intervals is quadratic in the unknowns and its minimum solves a
//! symmetric positive definite system, block tridiagonal with blocks of 2 x 2.

use crate::math;
use nalgebra::{Matrix2, Matrix2x3, Vector2};

/// Conditions at the first and the last knot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EndConditions {
    /// No condition: q''' and q'''' vanish there. Two knots give a straight line.
    Natural,
    /// No velocity and no acceleration.
    Clamped,
    /// The last knot equals the first: all derivatives up to the fourth agree. The values must be
    /// equal.
    Periodic,
}

/// Position, velocity and acceleration.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct TrajectoryPoint {
    /// rad or m.
    pub q: f64,
    /// Per s.
    pub v: f64,
    /// Per s^2.
    pub a: f64,
}

/// Why knots define no curve.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum SplineError {
    /// No knot, or lengths that differ.
    #[error("{times} times and {values} values do not form a curve")]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of values.
        values: usize,
    },
    /// A time or value that is not finite.
    #[error("{0} is not a finite number")]
    NotFinite(f64),
    /// Times that do not increase.
    #[error("times must increase, but {1} follows {0}")]
    Order(f64, f64),
    /// A periodic curve whose first and last value differ.
    #[error("a periodic curve must end at its first value {first}, not at {last}")]
    Open {
        /// Its first value.
        first: f64,
        /// Its last value.
        last: f64,
    },
}

/// A curve. Before its first knot it has its first value, after its last knot its last value, at
/// rest.
#[derive(Clone, PartialEq, Debug)]
pub struct Spline {
    times: Vec<f64>,
    knots: Vec<TrajectoryPoint>,
}

/// Integral of the squared jerk of a quintic on an interval of length 1, as a quadratic form of its
/// end values.
const K: [[f64; 6]; 6] = [
    [720.0, 360.0, 60.0, -720.0, 360.0, -60.0],
    [360.0, 192.0, 36.0, -360.0, 168.0, -24.0],
    [60.0, 36.0, 9.0, -60.0, 24.0, -3.0],
    [-720.0, -360.0, -60.0, 720.0, -360.0, 60.0],
    [360.0, 168.0, 24.0, -360.0, 192.0, -36.0],
    [-60.0, -24.0, -3.0, 60.0, -36.0, 9.0],
];

impl Spline {
    /// The curve through `values` (rad or m) at `times` (s).
    ///
    /// # Errors
    /// [`SplineError`].
    pub fn new(times: Vec<f64>, values: &[f64], ends: EndConditions) -> Result<Self, SplineError> {
        if times.len() != values.len() || times.is_empty() {
            return Err(SplineError::Lengths { times: times.len(), values: values.len() });
        }
        if let Some(x) = times.iter().chain(values).find(|x| !x.is_finite()) {
            return Err(SplineError::NotFinite(*x));
        }
        if let Some(pair) = times.windows(2).find(|pair| pair[1] <= pair[0]) {
            return Err(SplineError::Order(pair[0], pair[1]));
        }
        let (first, last) = (values[0], values[values.len() - 1]);
        if ends == EndConditions::Periodic && first != last {
            return Err(SplineError::Open { first, last });
        }
        let derivatives = match (values.len(), ends) {
            (1, _) | (2, EndConditions::Clamped | EndConditions::Periodic) => vec![Vector2::zeros(); values.len()],
            (2, EndConditions::Natural) => vec![Vector2::new((last - first) / (times[1] - times[0]), 0.0); 2],
            (_, EndConditions::Periodic) => periodic(&times, values),
            (n, EndConditions::Clamped) => {
                let mut inner = System::new(&times, values).part(1..n - 1).solve();
                inner.insert(0, Vector2::zeros());
                inner.push(Vector2::zeros());
                inner
            }
            (n, EndConditions::Natural) => System::new(&times, values).part(0..n).solve(),
        };
        let knots = values.iter().zip(derivatives).map(|(&q, d)| TrajectoryPoint { q, v: d.x, a: d.y }).collect();
        Ok(Spline { times, knots })
    }

    /// Times of the first and the last knot, s.
    pub fn span(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// The first knot after time `t`, s.
    pub fn knot_after(&self, t: f64) -> Option<f64> {
        self.times.get(self.times.partition_point(|knot| *knot <= t)).copied()
    }

    /// The point at time `t`. `cursor` (0 at first) remembers the interval, so that moving forward
    /// is fast.
    pub fn at(&self, t: f64, cursor: &mut usize) -> TrajectoryPoint {
        let last = self.times.len() - 1;
        if t < self.times[0] || last == 0 {
            return TrajectoryPoint { q: self.knots[0].q, ..TrajectoryPoint::default() };
        }
        if t > self.times[last] {
            return TrajectoryPoint { q: self.knots[last].q, ..TrajectoryPoint::default() };
        }
        if *cursor >= last || t < self.times[*cursor] {
            *cursor = 0;
        }
        while *cursor + 1 < last && t >= self.times[*cursor + 1] {
            *cursor += 1;
        }
        let i = *cursor;
        quintic(&self.knots[i], &self.knots[i + 1], self.times[i + 1] - self.times[i], t - self.times[i])
    }

    /// Time and value of the least and of the greatest value of the curve.
    pub fn extremes(&self) -> [(f64, f64); 2] {
        const PARTS: usize = 16;
        let first = (self.times[0], self.knots[0].q);
        let mut found = [first, first];
        let mut update = |t: f64, q: f64| {
            if q < found[0].1 {
                found[0] = (t, q);
            }
            if q > found[1].1 {
                found[1] = (t, q);
            }
        };
        for (i, pair) in self.knots.windows(2).enumerate() {
            let h = self.times[i + 1] - self.times[i];
            let at = |t: f64| quintic(&pair[0], &pair[1], h, t);
            for part in 0..PARTS {
                let [mut low, mut high] = [part, part + 1].map(|p| h * p as f64 / PARTS as f64);
                if at(low).v * at(high).v < 0.0 {
                    let rising = at(low).v > 0.0;
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        if (at(middle).v > 0.0) == rising { low = middle } else { high = middle }
                    }
                }
                update(self.times[i] + high, at(high).q);
            }
        }
        found
    }
}

/// The quintic with these ends on an interval of length h, at time t in it.
pub fn quintic(from: &TrajectoryPoint, to: &TrajectoryPoint, h: f64, t: f64) -> TrajectoryPoint {
    let d = to.q - from.q - h * (from.v + 0.5 * h * from.a);
    let v = (to.v - from.v - h * from.a) * h;
    let a = (to.a - from.a) * h * h;
    let s = t / h;
    let (c3, c4, c5) = (10.0 * d - 4.0 * v + 0.5 * a, -15.0 * d + 7.0 * v - a, 6.0 * d - 3.0 * v + 0.5 * a);
    TrajectoryPoint {
        q: from.q + t * (from.v + 0.5 * t * from.a) + s * s * s * (c3 + s * (c4 + s * c5)),
        v: from.v + t * from.a + s * s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)) / h,
        a: from.a + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5)) / (h * h),
    }
}

/// `lower_i x_(i-1) + diagonal_i x_i + lower_(i+1)^T x_(i+1) = right_i`. The third column on the
/// right belongs to the knots; the other two serve to close a periodic curve.
struct System {
    diagonal: Vec<Matrix2<f64>>,
    /// Coupling of `i` (rows) to `i - 1`; the first is unused.
    lower: Vec<Matrix2<f64>>,
    right: Vec<Matrix2x3<f64>>,
}

/// Rows `r..r+2`, columns `c..c+2` of K scaled to an interval of length h and unscaled unknowns.
fn block(r: usize, c: usize, h: f64) -> Matrix2<f64> {
    Matrix2::from_fn(|i, j| K[r + i][c + j] * math::powi(h, (i + j) as i32 - 3))
}

/// Gradient with respect to the unknowns in rows `r..r+2` of values that differ by `step` over an
/// interval of length h.
fn gradient(r: usize, h: f64, step: f64) -> Vector2<f64> {
    Vector2::from_fn(|i, _| K[r + i][3] * math::powi(h, i as i32 - 4) * step)
}

impl System {
    fn new(times: &[f64], values: &[f64]) -> Self {
        let n = times.len();
        let mut diagonal = vec![Matrix2::zeros(); n];
        let coupling = times.windows(2).map(|pair| block(4, 1, pair[1] - pair[0]));
        let lower = std::iter::once(Matrix2::zeros()).chain(coupling).collect();
        let mut right = vec![Matrix2x3::zeros(); n];
        for i in 1..n {
            let (h, step) = (times[i] - times[i - 1], values[i] - values[i - 1]);
            diagonal[i - 1] += block(1, 1, h);
            diagonal[i] += block(4, 4, h);
            let mut add = |at: usize, r: usize| {
                let sum = right[at].column(2) - gradient(r, h, step);
                right[at].set_column(2, &sum);
            };
            add(i - 1, 1);
            add(i, 4);
        }
        System { diagonal, lower, right }
    }

    /// The equations and unknowns in a range, with the others set to zero.
    fn part(&self, range: std::ops::Range<usize>) -> System {
        System {
            diagonal: self.diagonal[range.clone()].to_vec(),
            lower: self.lower[range.clone()].to_vec(),
            right: self.right[range].to_vec(),
        }
    }

    fn solve(self) -> Vec<Vector2<f64>> {
        self.solve_all().into_iter().map(|x| x.column(2).into_owned()).collect()
    }

    /// Block elimination and back substitution.
    fn solve_all(mut self) -> Vec<Matrix2x3<f64>> {
        let n = self.diagonal.len();
        for i in 1..n {
            let factor = self.lower[i] * inverse(&self.diagonal[i - 1]);
            self.diagonal[i] -= factor * self.lower[i].transpose();
            let carried = factor * self.right[i - 1];
            self.right[i] -= carried;
        }
        for i in (0..n).rev() {
            if i + 1 < n {
                let carried = self.lower[i + 1].transpose() * self.right[i + 1];
                self.right[i] -= carried;
            }
            self.right[i] = inverse(&self.diagonal[i]) * self.right[i];
        }
        self.right
    }
}

/// Inverse of a positive definite matrix.
fn inverse(m: &Matrix2<f64>) -> Matrix2<f64> {
    Matrix2::new(m.m22, -m.m12, -m.m21, m.m11) / (m.m11 * m.m22 - m.m12 * m.m21)
}

/// Periodic curve: the first knot equals the last one; its unknowns are eliminated last.
fn periodic(times: &[f64], values: &[f64]) -> Vec<Vector2<f64>> {
    let n = times.len();
    let all = System::new(times, values);
    let mut inner = all.part(1..n - 1);
    let last = n - 3;
    // Contribution of the first knot's unknowns to the other equations, per unit.
    for (i, coupling) in [(0, all.lower[1]), (last, all.lower[n - 1].transpose())] {
        for c in 0..2 {
            let sum = inner.right[i].column(c) - coupling.column(c);
            inner.right[i].set_column(c, &sum);
        }
    }
    let inner = inner.solve_all();
    let (to_first, to_last) = (all.lower[1].transpose(), all.lower[n - 1]);
    let carried = to_first * inner[0] + to_last * inner[last];
    let own = all.right[0] + all.right[n - 1] - carried;
    let matrix = all.diagonal[0] + all.diagonal[n - 1] + carried.fixed_columns::<2>(0);
    let first = inverse(&matrix) * own.column(2);
    let others = inner.iter().map(|x| x.fixed_columns::<2>(0) * first + x.column(2));
    std::iter::once(first).chain(others).chain(std::iter::once(first)).collect()
}

#[cfg(test)]
mod tests;
