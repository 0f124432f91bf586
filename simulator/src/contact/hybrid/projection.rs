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
    p.clear_turning_directions();
    for sole in &mut p.soles {
        sole.target = Vector3::zeros();
        sole.turning.bias = Vector3::zeros();
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

/// Sets the problem of position errors, after [`set_velocity_errors`]. `error_of` gives the position of
/// a vertex relative to its target, floor axes, m.
pub(crate) fn set_position_errors(
    p: &mut Problem,
    states: &States,
    error_of: impl Fn(&Problem, usize, usize) -> Vector3<f64>,
) -> Drift {
    p.b.fill(0.0);
    let mut drift = Drift::default();
    for s in 0..p.soles.len() {
        let state = states[s];
        if state.normal_rows() == 0 {
            continue;
        }
        let k = p.soles[s].vertices.len();
        let mut error = [Vector3::zeros(); MAX_VERTICES];
        for (i, error) in error.iter_mut().enumerate().take(k) {
            *error = error_of(p, s, i);
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
    let (mean, a, b) = moments(sole, value, |_| true);
    let tilt = match sole.vertices.len() {
        0 | 1 => Vector2::zeros(),
        2 => tilt_on_line(&a, &b),
        _ => a.try_inverse().map_or(Vector2::zeros(), |a| a * b),
    };
    Vector3::new(mean, tilt.x, tilt.y)
}

/// The least rotation through values on a line, from their normal equations.
fn tilt_on_line(a: &Matrix2<f64>, b: &Vector2<f64>) -> Vector2<f64> {
    if a.trace() > 0.0 { b / a.trace() } else { Vector2::zeros() }
}

/// Spread of the vertices seen from above, as a ratio of areas (of squares of two lengths for two vertices),
/// below which a sole stands perpendicular to the floor: its gaps are then no function of the position on
/// the floor.
const PERPENDICULAR: f64 = 1e-6;

/// The plane of the gaps of a sole's vertices. Only those of vertices that are near count if the sole
/// is perpendicular to the floor, as when its foot lies on its side.
pub(crate) fn fit_gaps(sole: &SoleProblem, value: impl Fn(usize) -> f64) -> Vector3<f64> {
    let (_, a, _) = moments(sole, &value, |_| true);
    let is_flat = match &sole.vertices[..] {
        [] | [_] => true,
        [v, w] => (v.r - w.r).xy().norm_squared() > PERPENDICULAR * (v.r - w.r).norm_squared(),
        _ => a.determinant() > PERPENDICULAR * a.trace() * a.trace(),
    };
    if is_flat {
        return fit_plane(sole, value);
    }
    let near = |i: usize| sole.vertices[i].near;
    if !(0..sole.vertices.len()).any(near) {
        return Vector3::zeros();
    }
    let (mean, a, b) = moments(sole, &value, near);
    // Near vertices are on a line.
    let tilt = tilt_on_line(&a, &b);
    let middle = middle(sole, near);
    Vector3::new(mean - tilt.x * middle.y + tilt.y * middle.x, tilt.x, tilt.y)
}

/// Mean of the values at the vertices used, and the normal equations of the rotation about their
/// middle that fits the remainder.
fn moments(
    sole: &SoleProblem,
    value: impl Fn(usize) -> f64,
    used: impl Fn(usize) -> bool + Copy,
) -> (f64, Matrix2<f64>, Vector2<f64>) {
    let vertices = || (0..sole.vertices.len()).filter(|i| used(*i));
    let count = vertices().count() as f64;
    let mean = vertices().map(&value).sum::<f64>() / count;
    let middle = if count < sole.vertices.len() as f64 { middle(sole, used) } else { Vector2::zeros() };
    let (mut a, mut b) = (Matrix2::zeros(), Vector2::zeros());
    for i in vertices() {
        let r = sole.vertices[i].r.xy() - middle;
        let row = Vector2::new(r.y, -r.x);
        a += row * row.transpose();
        b += row * (value(i) - mean);
    }
    (mean, a, b)
}

/// Middle of the vertices used, relative to the reference point, seen from above.
fn middle(sole: &SoleProblem, used: impl Fn(usize) -> bool) -> Vector2<f64> {
    let (mut sum, mut count) = (Vector2::zeros(), 0.0);
    for v in (0..sole.vertices.len()).filter(|i| used(*i)).map(|i| &sole.vertices[i]) {
        sum += v.r.xy();
        count += 1.0;
    }
    sum / count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2 that stands on its edge from (-1, 0, 0) to (1, 0, 0), turned about it.
    fn standing(lean: f64) -> SoleProblem {
        let (s, c) = crate::math::sin_cos(lean);
        let corners = [(-1.0, 0.0), (1.0, 0.0), (1.0, 2.0), (-1.0, 2.0)];
        let mut sole = Problem::new(&[4]).soles.remove(0);
        for (v, (along, up)) in sole.vertices.iter_mut().zip(corners) {
            (v.height, v.near) = (up * c, up == 0.0);
            v.r = Vector3::new(along, (up - 1.0) * s, (up - 1.0) * c);
        }
        sole
    }

    #[test]
    fn gaps_of_near_vertices_are_met_however_a_sole_stands() {
        for lean in [0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 1.0] {
            let mut sole = standing(lean);
            // The edge itself is 0.3 and 0.1 m above the floor.
            let gaps = [0.3, 0.1];
            let heights: Vec<f64> = (0..4).map(|i| sole.vertices[i].height + [0.3, 0.1, 0.1, 0.3][i]).collect();
            sole.target = fit_gaps(&sole, |i| heights[i]);
            for (i, gap) in gaps.into_iter().enumerate() {
                // Rounding of the normal equations, whose condition is below 1 / PERPENDICULAR.
                assert!((sole.vertex_target(i) - gap).abs() < 1e-9, "{lean} {i}: {}", sole.vertex_target(i));
            }
        }
    }

    #[test]
    fn gaps_of_an_inclined_line_foot_are_met() {
        for lean in [0.0, 1e-9, 1e-3, 0.3, 1.2, std::f64::consts::FRAC_PI_2] {
            let (s, c) = crate::math::sin_cos(lean);
            let mut sole = Problem::new(&[2]).soles.remove(0);
            sole.vertices[0].r = Vector3::new(-0.2 * c, 0.1 * c, -0.2 * s);
            sole.vertices[1].r = -sole.vertices[0].r;
            sole.vertices[0].near = true;
            let heights = [0.01, 0.01 + 0.4 * s];
            sole.target = fit_gaps(&sole, |i| heights[i]);
            // Only the near vertex has its gap if the foot is perpendicular to the floor.
            let met = if c < 1e-9 { 1 } else { 2 };
            for (i, height) in heights.into_iter().enumerate().take(met) {
                assert!((sole.vertex_target(i) - height).abs() < 1e-12, "{lean} {i}: {}", sole.vertex_target(i));
            }
        }
    }
}
