//! Coupled joints and closed loops: conditions `c(q) = 0` on the tree of a mechanism.
//!
//! With `c' = G v` and `c'' = G v' + g`, the forces `G^T lambda` keep c'' at zero without work. In
//! the coordinates `x = L v'` of the factor M = L^T L the motion with the least deviation from the
//! free one [Udwadia 1992] is an orthogonal projection:
//!
//! ```text
//! C = L^-T G^T = Q R,      x = P x_free + Q d,      P = 1 - Q Q^T,      R^T d = -g
//! ```
//!
//! Q is orthonormal, from columns of C chosen by pivoting: conditions that depend on others up to
//! `REDUNDANT` are left out, so that redundant loops need no special case. The multipliers of least
//! norm follow from `R lambda = d - Q^T x_free`, where x_free includes the wrenches of contacts.
//!
//! | condition | c | row of G |
//! |---|---|---|
//! | coupling `q = p(x)` | q - p(x) | 1, -p'(x) |
//! | point | R_2^T (p_1 - p_2) | R_2^T (J_1 - J_2), both at p_1 |
//! | axes a on link 1, b on link 2, perpendicular | a . b | (a x b) . (J_w1 - J_w2) |
//! | rod of length l between p_1 and p_2 | (e . e - l^2) / 2 l, e = p_1 - p_2 | e . (J_1 - J_2) / l |
//!
//! A velocity-level step of length dt ends on the conditions to third order with half of their curvature,
//! and removes what velocity is left, `R^T d = -g / 2 - G v / dt`; its end, projected onto them, takes the
//! other half, as in RATTLE [Andersen 1983]. The multipliers include both. [`super::closing`] removes the
//! errors of steps from a state. [`super::conditions`] evaluates the conditions.
//!
//! Source: [Featherstone 2008], chapter 8.

use crate::robot::{LoopClosure, Model};
use nalgebra::Vector3;
use std::ops::Range;

/// Part of a condition that no others determine, below which it is redundant: rounding of its row.
const REDUNDANT: f64 = 1e-9;

/// Part of the curvature in a velocity-level step; the projection of its end has the rest.
const FIRST_PART: f64 = 0.5;

/// The conditions of a mechanism at the state last given to `kinematics::update`.
#[derive(Clone, Debug, Default)]
pub struct Constraints {
    pub(super) rows: usize,
    pub(super) nv: usize,
    /// G, row after row.
    pub(super) jacobian: Vec<f64>,
    /// c, rad or m, and g.
    pub error: Vec<f64>,
    pub(super) drift: Vec<f64>,
    /// Q, column after column; the first `rank` are valid.
    basis: Vec<f64>,
    rank: usize,
    /// C as it is reduced, and the lengths of its columns.
    columns: Vec<f64>,
    size: Vec<f64>,
    /// R: for each condition `rows` coefficients, by column of Q.
    coefficients: Vec<f64>,
    /// The conditions that gave the columns of Q.
    pivots: Vec<usize>,
    /// Reciprocal of the length of a velocity-level step, 1/s, which also removes `G v`; 0 in continuous time.
    rate: f64,
    /// Velocities with a prescribed motion, whose accelerations are given.
    is_prescribed: Vec<bool>,
    /// Directions of the rows of loops, world: linear, angular; zero for couplings.
    pub(super) directions: Vec<[Vector3<f64>; 2]>,
    pub(super) scratch: Scratch,
}

/// Scratch of [`Constraints::multipliers`].
#[derive(Clone, Debug, Default)]
pub(super) struct LeastNorm {
    t: Vec<f64>,
    s: Vec<f64>,
    z: Vec<f64>,
}

impl LeastNorm {
    pub(super) fn new(rows: usize) -> Self {
        LeastNorm { t: vec![0.0; rows * rows], s: vec![0.0; rows], z: vec![0.0; rows] }
    }
}

/// Scratch of [`super::closing`].
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// By condition, in the order of the columns of Q.
    pub d: Vec<f64>,
    /// By velocity.
    pub x: Vec<f64>,
    /// By condition.
    pub rates: Vec<f64>,
}

impl Constraints {
    pub(super) fn new(model: &Model) -> Self {
        let of_loop = |closure: &LoopClosure| closure.kind.number();
        let rows = model.couplings.len() + model.loops.iter().map(of_loop).sum::<usize>();
        let nv = model.nv();
        Constraints {
            rows,
            nv,
            jacobian: vec![0.0; rows * nv],
            error: vec![0.0; rows],
            drift: vec![0.0; rows],
            basis: vec![0.0; rows * nv],
            rank: 0,
            columns: vec![0.0; rows * nv],
            size: vec![0.0; rows],
            coefficients: vec![0.0; rows * rows],
            pivots: vec![0; rows],
            rate: 0.0,
            is_prescribed: vec![false; nv],
            directions: vec![[Vector3::zeros(); 2]; rows],
            scratch: Scratch { d: vec![0.0; rows], x: vec![0.0; nv], rates: vec![0.0; rows] },
        }
    }

    /// Number of conditions.
    pub fn number(&self) -> usize {
        self.rows
    }

    /// Number of independent ones.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The greatest error of a condition, m or rad.
    pub fn greatest_error(&self) -> f64 {
        greatest(&self.error)
    }

    /// The greatest error of these conditions, m or rad.
    pub fn greatest_error_of(&self, conditions: Range<usize>) -> f64 {
        greatest(&self.error[conditions])
    }

    /// Sets the length of a velocity-level step, s; `None` for continuous time.
    pub fn set_step(&mut self, dt: Option<f64>) {
        self.rate = dt.map_or(0.0, |dt| 1.0 / dt);
    }

    /// The columns of Q.
    #[inline]
    pub(super) fn basis(&self) -> impl Iterator<Item = &[f64]> {
        self.basis.chunks_exact(self.nv.max(1)).take(self.rank)
    }

    /// `P x`.
    pub(super) fn project(&self, x: &mut [f64]) {
        for q in self.basis() {
            let part = dot(q, x);
            x.iter_mut().zip(q).for_each(|(x, q)| *x -= part * q);
        }
    }

    /// Turns a free motion into the constrained one, `x = P x + Q d`, and writes d and `y = R lambda`. `v`
    /// are the velocities; prescribed ones have their accelerations in x.
    pub(super) fn constrain(&self, v: &[f64], x: &mut [f64], d: &mut [f64], y: &mut [f64]) {
        let first = if self.rate > 0.0 { FIRST_PART } else { 1.0 };
        for r in 0..self.rank {
            let i = self.pivots[r];
            let row = &self.jacobian[i * self.nv..][..self.nv];
            let given: f64 = (0..self.nv).filter(|k| self.is_prescribed[*k]).map(|k| row[k] * x[k]).sum();
            d[r] = -first * self.drift[i] - self.rate * dot(row, v) - given;
            y[r] = (first - 1.0) * self.drift[i];
        }
        self.substitute(d);
        self.substitute(y);
        for ((q, d), y) in self.basis().zip(&*d).zip(y) {
            let change = d - dot(q, x);
            x.iter_mut().zip(q).for_each(|(x, q)| *x += change * q);
            *y += change;
        }
    }

    /// `d = R^-T d` for the conditions of the columns of Q.
    fn substitute(&self, d: &mut [f64]) {
        for r in 0..self.rank {
            let coefficients = &self.coefficients[self.pivots[r] * self.rows..][..=r];
            let done: f64 = coefficients[..r].iter().zip(&*d).map(|(c, d)| c * d).sum();
            d[r] = (d[r] - done) / coefficients[r];
        }
    }

    /// Builds Q and R for the present factor, whose first half solve is `solve`: Gram-Schmidt, the column
    /// with the greatest remaining part first, each orthogonalised twice.
    pub(super) fn orthogonalize(&mut self, prescribed: &[usize], solve: impl Fn(&mut [f64])) {
        let (rows, nv) = (self.rows, self.nv);
        self.is_prescribed.fill(false);
        prescribed.iter().for_each(|k| self.is_prescribed[*k] = true);
        self.columns.copy_from_slice(&self.jacobian);
        self.coefficients.fill(0.0);
        for (i, column) in self.columns.chunks_exact_mut(nv).enumerate() {
            solve(column);
            prescribed.iter().for_each(|k| column[*k] = 0.0);
            self.size[i] = norm(column);
        }
        self.rank = 0;
        for r in 0..rows {
            // Parts that remain, relative to the whole column; chosen ones have none.
            let remaining = |i: usize| match self.pivots[..r].contains(&i) || self.size[i] == 0.0 {
                true => 0.0,
                false => norm(&self.columns[i * nv..][..nv]) / self.size[i],
            };
            let (best, part) =
                (0..rows).map(|i| (i, remaining(i))).fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
            if !(part > REDUNDANT) {
                break;
            }
            self.pivots[r] = best;
            let q = &mut self.basis[r * nv..][..nv];
            q.copy_from_slice(&self.columns[best * nv..][..nv]);
            let length = norm(q);
            q.iter_mut().for_each(|q| *q /= length);
            self.rank = r + 1;
            // Rounding of long sums along the columns found before.
            let (before, q) = self.basis.split_at_mut(r * nv);
            let q = &mut q[..nv];
            for other in before.chunks_exact(nv) {
                let along = dot(other, q);
                q.iter_mut().zip(other).for_each(|(q, o)| *q -= along * o);
            }
            let length = norm(q);
            q.iter_mut().for_each(|q| *q /= length);
            for (i, column) in self.columns.chunks_exact_mut(nv).enumerate() {
                let along = dot(q, column);
                self.coefficients[i * rows + r] += along;
                column.iter_mut().zip(&*q).for_each(|(c, q)| *c -= along * q);
            }
        }
    }

    /// The least change of the velocities, weighted by the mass matrix, with `G dv = -errors`, in
    /// half-solved coordinates; `d` is scratch.
    pub(super) fn correction(&self, errors: &[f64], d: &mut [f64], x: &mut [f64]) {
        for r in 0..self.rank {
            d[r] = -errors[self.pivots[r]];
        }
        self.substitute(d);
        x.fill(0.0);
        for (q, d) in self.basis().zip(&*d) {
            x.iter_mut().zip(q).for_each(|(x, q)| *x += d * q);
        }
    }

    /// The multipliers of least norm with `R lambda = y`; `y` is by column of Q.
    pub(super) fn multipliers(&self, y: &[f64], scratch: &mut LeastNorm, lambda: &mut [f64]) {
        // R = S T with orthonormal rows of T and a triangle S: S z = y, lambda = T^T z.
        let rows = self.rows;
        lambda.fill(0.0);
        for k in 0..self.rank {
            let (before, t) = scratch.t.split_at_mut(k * rows);
            let (t, s) = (&mut t[..rows], &mut scratch.s);
            (0..rows).for_each(|i| t[i] = self.coefficients[i * rows + k]);
            s.fill(0.0);
            // Twice, as the columns of Q.
            for _ in 0..2 {
                for (other, s) in before.chunks_exact(rows).zip(&mut *s) {
                    let along = dot(other, t);
                    *s += along;
                    t.iter_mut().zip(other).for_each(|(t, o)| *t -= along * o);
                }
            }
            let length = norm(t);
            t.iter_mut().for_each(|t| *t /= length);
            let done: f64 = s[..k].iter().zip(&scratch.z).map(|(s, z)| s * z).sum();
            scratch.z[k] = (y[k] - done) / length;
            lambda.iter_mut().zip(&*t).for_each(|(lambda, t)| *lambda += scratch.z[k] * t);
        }
    }

    /// Force and moment, world, of the loop whose rows begin with `row` on its first link at its first point.
    pub fn loop_load(&self, row: usize, lambda: &[f64]) -> [Vector3<f64>; 2] {
        let sum = |part: usize| -> Vector3<f64> {
            self.directions[row..].iter().zip(lambda).map(|(direction, lambda)| direction[part] * *lambda).sum()
        };
        [sum(0), sum(1)]
    }

    /// `(G^T lambda)_k`.
    pub fn load(&self, lambda: &[f64], k: usize) -> f64 {
        lambda.iter().enumerate().map(|(i, lambda)| lambda * self.jacobian[i * self.nv + k]).sum()
    }

    /// `G v`.
    pub fn rates(&self, v: &[f64], out: &mut [f64]) {
        self.jacobian.chunks_exact(self.nv.max(1)).zip(out).for_each(|(row, out)| *out = dot(row, v));
    }
}

/// Greatest magnitude of an entry; NaN if one is.
pub(super) fn greatest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most: f64, x| if x.abs() > most || x.is_nan() { x.abs() } else { most })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests;
