//! Tests strict copositivity of the normal coefficients of sliding vertices.
//!
//! If it is lost, some normal load accelerates the vertices that carry it into the floor.
//!
//! The normal coefficients K of sliding vertices (see [`super::painleve`]) lose strict copositivity
//! when `x . K x <= 0` for a load `x >= 0`. On the simplex `sum x = 1` the form takes its minimum
//! at a stationary point of one of the faces: on the vertices that x loads, `(K + K^T) x` is
//! constant. With up to [`FEW`] sliding vertices all faces are tested.

// For storage and solves; there are no products of two matrices.
#![allow(clippy::disallowed_types)]

use crate::contact::methods::contact_method::ContactSolver;
use crate::contact::model::problem::{Level, Problem, Tolerances, Vertex};
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::{SoleState, States};
use nalgebra::{DMatrix, DVector, Vector3};

/// With more vertices than this, only loads on up to three of them are tested.
const FEW: usize = 12;

/// A normal load on sliding vertices with its value of the form `x . K x`.
pub(crate) struct SlidingLoad {
    /// `x . K x / (x . x)`, 1/kg; unless it is positive, the load accelerates its vertices into the
    /// floor.
    pub value: f64,
    /// The same without friction, 1/kg.
    pub smooth: f64,
    /// Sole and vertex with the greatest share of the load.
    pub at: (usize, usize),
    /// For each vertex of each sole: whether it carries a part of the load.
    pub loaded: Vec<Vec<bool>>,
    /// The wrenches of the load with its friction, 6F.
    pub wrench: Vec<f64>,
}

/// The normal load of least `x . K x` on the vertices of `p` that slide on the floor; `None` if
/// nothing slides.
///
/// `method` gives the response of the sticking soles of `states`, in `scratch`; `p` is unchanged on
/// return.
pub(crate) fn least_sliding_load(
    p: &mut Problem,
    method: &mut dyn ContactSolver,
    states: &States,
    tol: &Tolerances,
    scratch: &mut Solution,
) -> Option<SlidingLoad> {
    let slides = |v: &Vertex| v.is_in_band(tol) && v.velocity.xy().norm() > tol.rest;
    let moving: Vec<_> = p.vertex_indices().filter(|&(s, i)| slides(&p.soles[s].vertices[i])).collect();
    let mut held = states.clone();
    for s in 0..p.soles.len() {
        if !held[s].is_static() || moving.iter().any(|(m, _)| *m == s) {
            held[s] = SoleState::FREE;
        }
    }
    let level = std::mem::replace(&mut p.level, Level::Velocity);
    let turning: Vec<_> = p.soles.iter().map(|s| s.turning.bias).collect();
    let (b, biases) = (p.b.clone(), scale_biases(p, 0.0));
    let (n, dim) = (moving.len(), p.dim());
    let (mut k, mut smooth) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for (friction, matrix) in [(1.0, &mut k), (0.0, &mut smooth)] {
        for (c, &(s, i)) in moving.iter().enumerate() {
            let six = sliding_wrench(&p.soles[s].vertices[i], friction);
            for r in 0..dim {
                p.b[r] = (0..6).map(|q| p.w[r * dim + 6 * s + q] * six[q]).sum();
            }
            method.respond(p, &held, scratch);
            for (r, &(t, j)) in moving.iter().enumerate() {
                matrix[(r, c)] = p.vertex_motion(&scratch.motion, t, j).z;
            }
        }
    }
    (p.level, p.b) = (level, b);
    p.soles.iter_mut().zip(&turning).for_each(|(s, bias)| s.turning.bias = *bias);
    p.soles.iter_mut().flat_map(|s| &mut s.vertices).zip(&biases).for_each(|(v, b)| v.bias = *b);
    let (value, load) = least(&k)?;
    let mut wrench = vec![0.0; dim];
    let mut loaded: Vec<_> = p.soles.iter().map(|s| vec![false; s.vertices.len()]).collect();
    for (&(s, i), x) in moving.iter().zip(&load) {
        let six = sliding_wrench(&p.soles[s].vertices[i], 1.0);
        loaded[s][i] = *x > 0.0;
        wrench[6 * s..6 * s + 6].iter_mut().zip(six).for_each(|(w, f)| *w += f * x);
    }
    let smooth = load.dot(&(smooth * &load)) / load.norm_squared();
    Some(SlidingLoad { value, smooth, at: moving[load.imax()], loaded, wrench })
}

/// Wrench of one newton along the normal, with the fraction `friction` of the sliding friction.
fn sliding_wrench(v: &Vertex, friction: f64) -> [f64; 6] {
    let t = v.velocity.xy().normalize() * (-v.slip_mu() * friction);
    wrench_at(&v.r, &Vector3::new(t.x, t.y, 1.0))
}

/// Scales the centripetal terms by `factor`; returns their former values.
pub(crate) fn scale_biases(p: &mut Problem, factor: f64) -> Vec<Vector3<f64>> {
    let scale = |v: &mut Vertex| {
        let bias = v.bias;
        v.bias *= factor;
        bias
    };
    p.soles.iter_mut().for_each(|s| s.turning.bias *= factor);
    p.soles.iter_mut().flat_map(|s| &mut s.vertices).map(scale).collect()
}

/// Least `x . K x / (x . x)` among the stationary points of `x . K x` over `x >= 0`, `sum x = 1`,
/// and that x. The form is negative somewhere on that set only if it is negative at one of them.
fn least(k: &DMatrix<f64>) -> Option<(f64, DVector<f64>)> {
    let n = k.nrows();
    let form = (k + k.transpose()) * 0.5;
    let sets: Vec<Vec<usize>> = if n <= FEW {
        (1u32..1 << n).map(|set| (0..n).filter(|i| set >> i & 1 == 1).collect()).collect()
    } else {
        let triples = (0..n).flat_map(|a| (a..n).flat_map(move |b| (b..n).map(move |c| vec![a, b, c])));
        triples
            .map(|mut set| {
                set.dedup();
                set
            })
            .collect()
    };
    let stationary = |set: Vec<usize>| {
        let part = DMatrix::from_fn(set.len(), set.len(), |r, c| form[(set[r], set[c])]);
        let z = part.lu().solve(&DVector::repeat(set.len(), 1.0))?;
        let x = &z / z.sum();
        let mut load = DVector::zeros(n);
        set.iter().zip(&x).for_each(|(i, x)| load[*i] = *x);
        let inside = x.iter().all(|x| *x > 0.0);
        inside.then(|| (load.dot(&(k * &load)) / load.norm_squared(), load))
    };
    sets.into_iter().filter_map(stationary).min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copositivity_differs_from_definiteness() {
        // Indefinite but positive on loads that push; negative only where both push; a negative
        // diagonal.
        let cases = [([1.0, 3.0, 3.0, 1.0], true), ([1.0, -3.0, -1.0, 1.0], false), ([1.0, 5.0, 5.0, -0.1], false)];
        for (entries, positive) in cases {
            let (value, load) = least(&DMatrix::from_row_slice(2, 2, &entries)).expect("a corner is stationary");
            assert_eq!(value > 0.0, positive, "{entries:?}: {value} at {load}");
            assert!(load.iter().all(|x| *x >= 0.0));
        }
    }

    #[test]
    fn a_negative_load_on_three_vertices_is_found() {
        // x . K x at (1, 1, 1) is -0.3; every pair is positive.
        let k = DMatrix::from_row_slice(3, 3, &[1.0, -0.55, -0.55, -0.55, 1.0, -0.55, -0.55, -0.55, 1.0]);
        let (value, load) = least(&k).expect("stationary");
        assert!(value < 0.0 && load.iter().all(|x| (x - 1.0 / 3.0).abs() < 1e-12), "{value} {load}");
    }
}
