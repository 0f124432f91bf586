//! Pressure rule: splits the normal load of a face over its vertices.
//!
//! The split over k >= 4 vertices is statically indeterminate. Rule (`docs/contact.md`, section 3):
//! the non-negative N of least norm that carries the normal force and the two tilting moments,
//!
//! ```text
//! min 1/2 |N|^2   with   sum A_i N_i = q,  N_i >= 0,      A_i = (1, x_i / rho, y_i / rho)
//! ```
//!
//! Its optimality conditions give `N_i = max(0, A_i . y)`: a linear pressure cut off at zero. `y`
//! minimises the convex dual `1/2 sum max(0, A_i . y)^2 - q . y`, found here by Newton steps on the
//! active set with step halving.

use crate::contact::model::problem::{SoleProblem, Vertex};
use crate::math;
use nalgebra::Vector3;

/// Row A_i of the pressure rule.
pub fn basis(sole: &SoleProblem, i: usize) -> Vector3<f64> {
    let r = &sole.vertices[i].r;
    Vector3::new(1.0, r.x / sole.radius, r.y / sole.radius)
}

/// Splits a face load. `force` is the normal force (N), `moment` the tilting moments about x and y
/// at the reference point (N m). Fills `normal` (one per vertex, N). Returns true if the centre of
/// pressure is inside the polygon. Otherwise `normal` holds the plain linear pressure, with
/// negative entries.
pub fn share(sole: &SoleProblem, force: f64, moment: [f64; 2], normal: &mut [f64]) -> bool {
    // Moments of N_i at (x_i, y_i): M_x = sum y_i N_i, M_y = -sum x_i N_i.
    let q = Vector3::new(force, -moment[1] / sole.radius, moment[0] / sole.radius);
    let Some(mut y) = newton_point(sole, &q, None) else {
        normal.fill(0.0);
        return false;
    };
    let linear = y;
    let vertices = &sole.vertices;
    let mut converged = vertices.iter().map(pressures(sole, &y)).all(|n| n >= 0.0);
    for _ in 0..50 {
        if converged {
            break;
        }
        let Some(target) = newton_point(sole, &q, Some(&y)) else { break };
        let value = dual(sole, &q, &y);
        let mut t = 1.0;
        while t > 1e-6 && dual(sole, &q, &(y + (target - y) * t)) > value {
            t *= 0.5;
        }
        let next = y + (target - y) * t;
        let (before, after) = (pressures(sole, &y), pressures(sole, &next));
        converged = t == 1.0 && vertices.iter().all(|v| (after(v) > 0.0) == (before(v) > 0.0));
        y = next;
    }
    let mut carried = Vector3::zeros();
    let pressure = pressures(sole, &y);
    for (to, v) in normal.iter_mut().zip(vertices) {
        let n = pressure(v).max(0.0);
        *to = n;
        carried += Vector3::new(n, v.r.x * n, v.r.y * n);
    }
    // With the centre of pressure outside, the damped steps converge to a pressure that does not
    // carry the load.
    let carried = carried.component_mul(&units(sole));
    let inside = converged && (carried - q).norm() <= 1e-9 * q.norm();
    if !inside {
        normal.iter_mut().zip(vertices.iter().map(pressures(sole, &linear))).for_each(|(to, n)| *to = n);
    }
    inside
}

/// (1, 1 / rho, 1 / rho).
fn units(sole: &SoleProblem) -> Vector3<f64> {
    let unit = 1.0 / sole.radius;
    Vector3::new(1.0, unit, unit)
}

/// `A_i . y` at each vertex.
fn pressures(sole: &SoleProblem, y: &Vector3<f64>) -> impl Fn(&Vertex) -> f64 + use<> {
    let y = y.component_mul(&units(sole));
    move |v| y.x + v.r.x * y.y + v.r.y * y.z
}

fn dual(sole: &SoleProblem, q: &Vector3<f64>, y: &Vector3<f64>) -> f64 {
    let sum: f64 = sole.vertices.iter().map(pressures(sole, y)).map(|n| math::powi(n.max(0.0), 2)).sum();
    0.5 * sum - q.dot(y)
}

/// Stationary point of the dual on the active set of `at` (all vertices when `None`).
fn newton_point(sole: &SoleProblem, q: &Vector3<f64>, at: Option<&Vector3<f64>>) -> Option<Vector3<f64>> {
    let at = at.map(|y| pressures(sole, y));
    let (mut number, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
    for v in sole.vertices.iter().filter(|v| at.as_ref().is_none_or(|pressure| pressure(v) > 0.0)) {
        let (x, y) = (v.r.x, v.r.y);
        number += 1.0;
        first = [first[0] + x, first[1] + y];
        second = [second[0] + x * x, second[1] + y * x, second[2] + y * y];
    }
    let unit = units(sole).y;
    let (first, second) = (first.map(|x| x * unit), second.map(|x| x * (unit * unit)));
    // A two-vertex active set (centre of pressure on an edge) leaves one direction undetermined.
    // Damping of relative size 1e-14 selects the least y and changes N by as much.
    let damping = 1e-14 * (number + second[0] + second[2]);
    let lower = [number + damping, first[0], first[1], second[0] + damping, second[1], second[2] + damping];
    solve_definite(lower, q)
}

/// Solves a symmetric system by its Cholesky factor L L^T. `a` is its lower triangle, column by
/// column. None if it is not positive definite.
fn solve_definite(a: [f64; 6], q: &Vector3<f64>) -> Option<Vector3<f64>> {
    let root = |x: f64| (x > 0.0).then(|| x.sqrt());
    let l00 = root(a[0])?;
    let (l10, l20) = (a[1] / l00, a[2] / l00);
    let l11 = root(a[3] - l10 * l10)?;
    let l21 = (a[4] - l10 * l20) / l11;
    let l22 = root(a[5] - l20 * l20 - l21 * l21)?;
    let x = q.x / l00;
    let y = (q.y - l10 * x) / l11;
    let z = (q.z - l20 * x - l21 * y) / l22 / l22;
    let y = (y - l21 * z) / l11;
    let x = (x - (l10 * y + l20 * z)) / l00;
    Some(Vector3::new(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::model::turning::Turning;

    fn square() -> SoleProblem {
        let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        SoleProblem {
            vertices: corners
                .iter()
                .map(|&(x, y)| Vertex { r: Vector3::new(x, y, 0.0), ..Vertex::default() })
                .collect(),
            radius: 2f64.sqrt(),
            body: 0,
            position: Vector3::zeros(),
            target: Vector3::zeros(),
            turning: Turning::default(),
        }
    }

    fn carry(cop: (f64, f64)) -> (bool, Vec<f64>) {
        let mut n = vec![0.0; 4];
        let inside = share(&square(), 10.0, [10.0 * cop.1, -10.0 * cop.0], &mut n);
        (inside, n)
    }

    #[test]
    fn a_central_load_is_shared_evenly() {
        let (inside, n) = carry((0.0, 0.0));
        assert!(inside && n.iter().all(|x| (x - 2.5).abs() < 1e-12));
    }

    #[test]
    fn any_load_inside_is_carried_exactly_without_tension() {
        for cop in [(0.3, 0.1), (0.8, 0.7), (0.95, -0.9), (-0.99, 0.0), (0.5, 0.5)] {
            let (inside, n) = carry(cop);
            assert!(inside, "{cop:?}");
            assert!(n.iter().all(|&x| x >= 0.0));
            let s = square();
            let sum: f64 = n.iter().sum();
            let x: f64 = n.iter().zip(&s.vertices).map(|(n, v)| n * v.r.x).sum::<f64>() / sum;
            let y: f64 = n.iter().zip(&s.vertices).map(|(n, v)| n * v.r.y).sum::<f64>() / sum;
            // Rounding and the 1e-14 damping, times a condition number of about 100 near a corner.
            assert!((sum - 10.0).abs() < 1e-10 && (x - cop.0).abs() < 1e-10 && (y - cop.1).abs() < 1e-10);
        }
    }

    #[test]
    fn a_centre_of_pressure_outside_is_refused() {
        for cop in [(1.01, 0.0), (1.2, 1.2), (0.0, -3.0)] {
            assert!(!carry(cop).0, "{cop:?}");
        }
    }
}
