//! The physical inertia tensor nearest to one that no body can have.
//!
//! A tensor J about the centre of mass belongs to a body when the second moments of its mass along
//! the principal axes, `s_i = tr(J) / 2 - J_i >= 0`, are not negative (the triangle inequality of
//! the principal moments J_i, which makes them not negative as well [Wensing 2018]). Here each
//! `s_i` must be at least [`THINNEST`] times their sum, so that the result can also be accelerated
//! about every axis. These tensors form a convex cone that is invariant under rotations, so the
//! nearest one in the Frobenius norm has the same principal axes, and its moments are the Euclidean
//! projection of the given ones onto the cone spanned by `(2e, 1-e, 1-e)` and its permutations.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Least share of the second moment of mass along one axis: a plate, rms thickness 3 % of the rms
/// size of the whole.
pub(super) const THINNEST: f64 = 1e-3;

/// The nearest physical tensor: `tensor` up to rounding if that is physical; zero, a point mass, if
/// the projection is the cone's apex.
pub(super) fn nearest_physical(tensor: &Matrix3<f64>) -> Matrix3<f64> {
    let eigen = SymmetricEigen::new(*tensor);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let ascending = Vector3::from_fn(|i, _| eigen.eigenvalues[order[i]]);
    let moments = project(&ascending);
    let axes = Matrix3::from_columns(&order.map(|i| eigen.eigenvectors.column(i).into_owned()));
    let repaired = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    // Rounding must not leave an asymmetric tensor.
    0.5 * (repaired + repaired.transpose())
}

/// The projection of ascending moments onto the cone. It keeps their order, so only the face under
/// the largest moment, between the first two edges, and the first edge can hold the answer.
fn project(m: &Vector3<f64>) -> Vector3<f64> {
    let e = THINNEST;
    let inward = Vector3::new(1.0 - e, 1.0 - e, -1.0 - e);
    let depth = inward.dot(m);
    if depth >= 0.0 && m.sum() >= 0.0 {
        return *m;
    }
    let first = Vector3::new(2.0 * e, 1.0 - e, 1.0 - e);
    let second = Vector3::new(1.0 - e, 2.0 * e, 1.0 - e);
    let on_face = m - inward * (depth / inward.norm_squared());
    // Weights of the two edges, from the first two components.
    let determinant = first.x * second.y - second.x * first.y;
    let a = (on_face.x * second.y - second.x * on_face.y) / determinant;
    let b = (first.x * on_face.y - on_face.x * first.y) / determinant;
    if a >= 0.0 && b >= 0.0 {
        return on_face;
    }
    first * (first.dot(m) / first.norm_squared()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    fn diagonal(a: f64, b: f64, c: f64) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::new(a, b, c))
    }

    /// Second moments of mass along the principal axes as shares of their sum.
    fn shares(tensor: &Matrix3<f64>) -> Vector3<f64> {
        let moments = SymmetricEigen::new(*tensor).eigenvalues;
        let half = 0.5 * moments.sum();
        moments.map(|m| (half - m) / half)
    }

    #[test]
    fn closed_forms() {
        let e = THINNEST;
        // Onto the face below the largest moment: (1, 1, 3) moves along (1-e, 1-e, -1-e) by its
        // distance.
        let n = Vector3::new(1.0 - e, 1.0 - e, -1.0 - e);
        let k = -(2.0 * (1.0 - e) - 3.0 * (1.0 + e)) / (2.0 * (1.0 - e).powi(2) + (1.0 + e).powi(2));
        let face = diagonal(1.0 + k * n.x, 1.0 + k * n.y, 3.0 + k * n.z);
        // Onto the edge of a rod along x: the mean of what (-1, 2, 2) has along (2e, 1-e, 1-e).
        let t = (4.0 * (1.0 - e) - 2.0 * e) / (2.0 * (1.0 - e).powi(2) + 4.0 * e * e);
        let edge = diagonal(2.0 * e * t, (1.0 - e) * t, (1.0 - e) * t);
        for (given, expected) in [
            (diagonal(1.0, 1.0, 3.0), face),
            (diagonal(-1.0, 2.0, 2.0), edge),
            // Physical ones stay: a ball, a plate of 10 cm by 1 cm thickness.
            (diagonal(1.0, 1.0, 1.0), diagonal(1.0, 1.0, 1.0)),
            (diagonal(1.01, 1.01, 2.0), diagonal(1.01, 1.01, 2.0)),
            // The apex: a point mass.
            (diagonal(-1.0, -2.0, -3.0), Matrix3::zeros()),
            (Matrix3::zeros(), Matrix3::zeros()),
        ] {
            // Rounding of the eigenvalues and of the products, a few units in the last place of 3.
            assert!((nearest_physical(&given) - expected).amax() < 1e-14, "{given} {}", nearest_physical(&given));
        }
    }

    proptest! {
        /// The projection onto a closed convex cone is the only point p of it with
        /// `(J - p) . p = 0` and `(J - p) . x <= 0` for every x of the cone.
        #[test]
        fn no_physical_tensor_is_nearer(
            moments in prop::array::uniform3(-1.0f64..2.0),
            turn in prop::array::uniform3(-3.0f64..3.0),
            other in prop::array::uniform3(1e-3f64..1.0),
            other_turn in prop::array::uniform3(-3.0f64..3.0),
        ) {
            let rotate = |m: Matrix3<f64>, a: [f64; 3]| {
                let r = UnitQuaternion::from_scaled_axis(Vector3::from(a)).to_rotation_matrix().into_inner();
                r * m * r.transpose()
            };
            let given = rotate(Matrix3::from_diagonal(&Vector3::from(moments)), turn);
            let found = nearest_physical(&given);
            // Rounding of eigenvalues of tensors of size 2.
            let rounding = 1e-13;
            prop_assert!((given - found).dot(&found).abs() < rounding);
            if found.trace() > 1e-6 {
                prop_assert!(shares(&found).min() > THINNEST - 1e-9);
            }
            // A body with any second moments s, none below the least share.
            let s = Vector3::from(other);
            let s = s.map(|x| x.max(1.01 * THINNEST * s.sum()));
            let body = rotate(Matrix3::from_diagonal(&s.map(|x| s.sum() - x)), other_turn);
            prop_assert!((given - found).dot(&body) < rounding);
        }
    }
}
