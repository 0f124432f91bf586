//! Removes drift: errors of rounding and integration in the clamped directions.
//!
//! The least mass-weighted change removes errors of velocity and position, `dq = M^-1 J^T w` with
//! `R (J dq + e) = 0` (`docs/contact.md`, section 8). It is the candidate solve at the velocity
//! level, without friction, with the errors as free motion. A static sole is held at the positions
//! of its vertices when it was clamped (its anchors), a sliding one at their heights.

use crate::contact::model::problem::{Level, Problem, SoleProblem};
use crate::contact::model::state::States;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Greatest number of vertices of a sole.
const MAX_VERTICES: usize = 64;

/// Sets the problem of velocity errors: `velocity` are the motions of the soles (6F).
pub(crate) fn set_velocity_errors(p: &mut Problem, velocity: &[f64]) {
    p.level = Level::Velocity;
    p.b.copy_from_slice(velocity);
    for sole in &mut p.soles {
        sole.target = Vector3::zeros();
        for v in &mut sole.vertices {
            v.bias = Vector3::zeros();
            v.direction = Vector2::zeros();
        }
    }
}

/// Greatest position errors of clamped vertices, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Drift {
    /// Error over all soles.
    pub greatest: f64,
    /// Error over static soles.
    pub of_static: f64,
}

/// Sets the problem of position errors, after [`set_velocity_errors`]. `origin` gives the reference
/// point of a sole and `anchors` the target positions of its vertices, floor axes relative to the
/// floor point, m.
pub(crate) fn set_position_errors(
    p: &mut Problem,
    states: &States,
    origin: impl Fn(usize) -> Vector3<f64>,
    anchors: &[Vec<Vector3<f64>>],
) -> Drift {
    p.b.fill(0.0);
    let mut drift = Drift::default();
    for s in 0..p.soles.len() {
        let state = states[s];
        if state.normal_rows() == 0 {
            continue;
        }
        let origin = origin(s);
        let k = p.soles[s].vertices.len();
        let mut error = [Vector3::zeros(); MAX_VERTICES];
        for (i, error) in error.iter_mut().enumerate().take(k) {
            *error = origin + p.soles[s].vertices[i].r - anchors[s][i];
            if state.is_dynamic() {
                *error = Vector3::new(0.0, 0.0, error.z);
            }
            if state.clamps(i, k) {
                drift.greatest = drift.greatest.max(error.norm());
                if state.is_static() {
                    drift.of_static = drift.of_static.max(error.norm());
                }
            }
        }
        let sole = &mut p.soles[s];
        if state.normal_rows() == 3 {
            let normal = fit_plane(sole, |i| error[i].z);
            let mean: Vector2<f64> = error[..k].iter().map(|e| e.xy()).sum::<Vector2<f64>>() / k as f64;
            let inertia: f64 = sole.vertices.iter().map(|v| v.r.xy().norm_squared()).sum();
            let yaw: f64 = sole.vertices.iter().zip(&error).map(|(v, e)| v.r.xy().perp(&e.xy())).sum::<f64>() / inertia;
            p.b[6 * s..6 * s + 6].copy_from_slice(&[mean.x, mean.y, normal.x, normal.y, normal.z, yaw]);
        } else {
            sole.vertices.iter_mut().zip(&error).for_each(|(v, e)| v.bias = *e);
        }
    }
    drift
}

/// Least-squares plane through values at the vertices: the value at the reference point and the
/// small rotation (about x and y) whose normal motion `t_x r_y - t_y r_x` fits the remainder.
pub(crate) fn fit_plane(sole: &SoleProblem, value: impl Fn(usize) -> f64) -> Vector3<f64> {
    let k = sole.vertices.len();
    let mean = (0..k).map(&value).sum::<f64>() / k as f64;
    let (mut a, mut b) = (Matrix2::zeros(), Vector2::zeros());
    for (i, v) in sole.vertices.iter().enumerate() {
        let row = Vector2::new(v.r.y, -v.r.x);
        a += row * row.transpose();
        b += row * (value(i) - mean);
    }
    let tilt = if k > 2 { a.try_inverse().map_or(Vector2::zeros(), |a| a * b) } else { Vector2::zeros() };
    Vector3::new(mean, tilt.x, tilt.y)
}
