//! Comparison and numerical differentiation.

use nalgebra::{DMatrix, Vector3};
use stiction::dynamics::{self, State, TreeMatrix, Workspace};
use stiction::robot::Model;

pub const GRAVITY: Vector3<f64> = Vector3::new(0.3, -0.2, -9.7);

/// Greatest absolute difference, relative to the greatest entry of `truth` (at least 1).
pub fn error(got: &[f64], truth: &[f64]) -> f64 {
    assert_eq!(got.len(), truth.len());
    let scale = truth.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
    // `max` would drop a NaN; adding keeps it, and a NaN fails every bound.
    let worst = got.iter().zip(truth).fold(0.0, |a: f64, (g, t)| {
        let d = (g - t).abs();
        if d > a || d.is_nan() { d } else { a }
    });
    worst / scale
}

#[track_caller]
pub fn assert_near(what: &str, got: &[f64], truth: &[f64], bound: f64) {
    let e = error(got, truth);
    assert!(e <= bound, "{what}: error {e:e} above {bound:e}\n got {got:?}\n truth {truth:?}");
}

pub fn prepared(model: &Model, state: &State) -> Workspace {
    let mut ws = Workspace::new(model);
    dynamics::prepare(model, state, &GRAVITY, &mut ws).expect("random trees move mass everywhere");
    ws
}

pub fn dense(m: &TreeMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(m.len(), m.len(), |i, j| m.get(i, j))
}

/// Central difference of a vector function along the motion with constant `v`: f(q + t v) at t = +-step.
pub fn along(state: &State, v: &[f64], step: f64, mut f: impl FnMut(&State) -> Vec<f64>) -> Vec<f64> {
    let mut at = |t: f64| {
        let mut s = state.clone();
        s.displace(&v.iter().map(|x| x * t).collect::<Vec<_>>());
        f(&s)
    };
    let (a, b) = (at(-step), at(step));
    a.iter().zip(&b).map(|(a, b)| (b - a) / (2.0 * step)).collect()
}
