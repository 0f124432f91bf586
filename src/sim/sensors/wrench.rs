//! Sole forces as a force-torque sensor tells them.

use crate::contact::problem::SoleProblem;
use crate::task::sensed::SoleLoad;
use nalgebra::{Matrix3, Vector3};

/// A part of what a sole's sensor reads.
pub(super) type Part = fn(&mut SoleLoad) -> &mut Vector3<f64>;

/// The force.
pub(super) fn force(sole: &mut SoleLoad) -> &mut Vector3<f64> {
    &mut sole.force
}

/// The moment.
pub(super) fn moment(sole: &mut SoleLoad) -> &mut Vector3<f64> {
    &mut sole.moment
}

/// Moves the forces of a sole's vertices by as little as makes them add up to its force F and its moment M about their
/// centroid: with errors dF and dM of the present sums over k vertices at r_i from the centroid,
///
/// ```text
/// f_i += dF / k + (S^-1 dM) x r_i        S = sum |r_i|^2 1 - r_i r_i^T
/// ```
///
/// the least change in the sum of squares. Where the vertices lie on a line S is inverted in the directions it has; a
/// moment along the line is out of their reach.
pub(super) fn share(sole: &SoleProblem, floor: &Matrix3<f64>, load: &mut SoleLoad) {
    let k = load.vertices.len() as f64;
    let arm = |i: usize| floor * sole.vertices[i].r;
    let (mut force, mut moment, mut spread) = (load.force, load.moment, Matrix3::zeros());
    for (i, f) in load.vertices.iter().enumerate() {
        let r = arm(i);
        force -= f;
        moment -= r.cross(f);
        spread += Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose();
    }
    let size = spread.trace();
    let eigen = spread.symmetric_eigen();
    let inverse = eigen.eigenvalues.map(|l| if l > 1e-9 * size { 1.0 / l } else { 0.0 });
    let turn = eigen.eigenvectors * inverse.component_mul(&eigen.eigenvectors.tr_mul(&moment));
    for (i, f) in load.vertices.iter_mut().enumerate() {
        *f += force / k + turn.cross(&arm(i));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::problem::Problem;

    #[test]
    fn shares_add_up_to_the_wrench() {
        let mut problem = Problem::new(&[4]);
        let corners = [(0.06, 0.03), (-0.04, 0.03), (-0.04, -0.03), (0.06, -0.03)];
        let centre = Vector3::new(0.01, 0.0, 0.0);
        for (v, (x, y)) in problem.soles[0].vertices.iter_mut().zip(corners) {
            v.r = Vector3::new(x, y, 0.0) - centre;
        }
        let floor = *nalgebra::Rotation3::from_euler_angles(0.1, -0.2, 0.3).matrix();
        let mut load = SoleLoad {
            force: Vector3::new(3.0, -2.0, 40.0),
            moment: Vector3::new(0.3, -0.5, 0.2),
            resolved: true,
            vertices: vec![Vector3::new(0.1, 0.2, 9.0); 4],
            clamped: vec![true; 4],
        };
        share(&problem.soles[0], &floor, &mut load);
        let sum: Vector3<f64> = load.vertices.iter().sum();
        let moment: Vector3<f64> =
            load.vertices.iter().zip(&problem.soles[0].vertices).map(|(f, v)| (floor * v.r).cross(f)).sum();
        // Rounding of a 3 x 3 eigenproblem.
        assert!((sum - load.force).norm() < 1e-12 && (moment - load.moment).norm() < 1e-12, "{sum} {moment}");
    }

    #[test]
    fn a_point_foot_carries_its_force() {
        let problem = Problem::new(&[1]);
        let mut load = SoleLoad {
            force: Vector3::new(0.0, 1.0, 5.0),
            moment: Vector3::new(0.1, 0.0, 0.0),
            resolved: true,
            vertices: vec![Vector3::zeros()],
            clamped: vec![true],
        };
        share(&problem.soles[0], &Matrix3::identity(), &mut load);
        assert_eq!(load.vertices[0], load.force);
    }
}
