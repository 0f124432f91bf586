//! Volume, centre and second moments of a polyhedron.
//!
//! ```text
//! T_k = tetrahedron (o, a, b, c) of face k      V_k = (a - o) . (b - o) x (c - o) / 6
//! V = sum V_k      int x dV = sum V_k (a + b + c) / 4
//! int x x^T dV = sum V_k / 20 (a a^T + b b^T + c c^T + s s^T),   s = a + b + c      (o = 0)
//! ```
//!
//! The face is the triangle (a, b, c), counter-clockwise seen from outside. V_k is negative where the
//! origin o is outside of its plane, so that the sums hold for every o. o is a corner, which keeps the
//! rounding of bodies far from the origin small.

use nalgebra::{Matrix3, Vector3};

/// Moments of a homogeneous body of unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Volume, m^3.
    pub volume: f64,
    /// Centre of mass, m.
    pub centre: Vector3<f64>,
    /// Inertia tensor about the centre per mass, m^2.
    pub inertia: Matrix3<f64>,
}

/// Moments of the closed polyhedron of these triangles; `None` if its volume is not above 0.
pub fn moments(triangles: impl Iterator<Item = [Vector3<f64>; 3]> + Clone) -> Option<Moments> {
    let origin = triangles.clone().next()?[0];
    let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|p| p - origin);
        let part = a.dot(&b.cross(&c)) / 6.0;
        let sum = a + b + c;
        volume += part;
        first += sum * (part / 4.0);
        let squares = [a, b, c, sum].into_iter().fold(Matrix3::zeros(), |total, p| total + p * p.transpose());
        second += squares * (part / 20.0);
    }
    if !(volume > 0.0) {
        return None;
    }
    let centre = first / volume;
    let about_centre = second / volume - centre * centre.transpose();
    let inertia = Matrix3::identity() * about_centre.trace() - about_centre;
    Some(Moments { volume, centre: origin + centre, inertia })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    /// A block with two opposite corners, as twelve triangles.
    fn block(from: [f64; 3], to: [f64; 3]) -> Vec<[Vector3<f64>; 3]> {
        let corner = |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 0 { from[axis] } else { to[axis] });
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let halves = faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]);
        halves.map(|half| half.map(corner)).collect()
    }

    #[test]
    fn a_turned_block_far_away_has_its_moments() {
        let turn = Rotation3::from_euler_angles(0.3, -0.7, 1.1);
        let far = Vector3::new(100.0, -50.0, 20.0);
        let triangles: Vec<_> = block([-0.1, -0.2, -0.3], [0.3, 0.0, 0.4])
            .into_iter()
            .map(|triangle| triangle.map(|p| turn * p + far))
            .collect();
        let found = moments(triangles.iter().copied()).unwrap();
        // Rounding of coordinates near 100 m.
        assert!((found.volume - 0.4 * 0.2 * 0.7).abs() < 1e-12, "{}", found.volume);
        assert!((found.centre - (turn * Vector3::new(0.1, -0.1, 0.05) + far)).norm() < 1e-12);
        let squares = Vector3::new(0.16, 0.04, 0.49);
        let own = Matrix3::from_diagonal(&squares.map(|s| squares.sum() - s)) / 12.0;
        let expected = turn.matrix() * own * turn.matrix().transpose();
        assert!((found.inertia - expected).amax() < 1e-12, "{}", found.inertia - expected);
    }

    #[test]
    fn a_tetrahedron_has_the_moments_of_its_integral() {
        // x, y, z >= 0, x/a + y/b + z/c <= 1: int x^2 = V a^2 / 10, int x y = V a b / 20.
        let (a, b, c) = (0.6, 0.9, 0.3);
        let corners = [Vector3::zeros(), Vector3::x() * a, Vector3::y() * b, Vector3::z() * c];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let found = moments(faces.iter().map(|f| f.map(|k: usize| corners[k]))).unwrap();
        assert!((found.volume - a * b * c / 6.0).abs() < 1e-16);
        assert!((found.centre - Vector3::new(a, b, c) / 4.0).norm() < 1e-15);
        let second = |p: f64, q: f64, same: bool| p * q * (if same { 0.1 } else { 0.05 } - 1.0 / 16.0);
        let s = Matrix3::from_fn(|i, j| second([a, b, c][i], [a, b, c][j], i == j));
        let expected = Matrix3::identity() * s.trace() - s;
        assert!((found.inertia - expected).amax() < 1e-16, "{}", found.inertia - expected);
    }

    #[test]
    fn a_flat_or_inverted_body_has_no_moments() {
        assert_eq!(moments(block([0.0; 3], [1.0, 1.0, 0.0]).into_iter()), None);
        let inverted = block([0.0; 3], [1.0; 3]).into_iter().map(|[a, b, c]| [a, c, b]);
        assert_eq!(moments(inverted.collect::<Vec<_>>().into_iter()), None);
        assert_eq!(moments(std::iter::empty()), None);
    }
}
