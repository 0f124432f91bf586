//! Mass properties of triangle meshes by MuJoCo's four rules, density 1.
//!
//! A mesh is the sum of the tetrahedra between its triangles (D, E, F) and a point. With a point in
//! O and the volume V, the second moments of one are `V / 20 (2 (DD^T + EE^T + FF^T) + DE^T + ED^T
//! + DF^T + FD^T + EF^T + FE^T)`; those of a triangle of area A are the same with A / 24 in place
//! of V / 20 ([MuJoCo], XML reference, `mesh/inertia`). The inertia is `tr(P) 1 - P`.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::robot::rigid_inertia::RigidInertia;

/// How the mass of a mesh is distributed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Rule {
    /// The convex hull is full.
    Convex,
    /// The volume within the surface, by signed tetrahedra.
    Exact,
    /// Unsigned tetrahedra from the mean of the surface, then from the centre: counts hollows of
    /// meshes that are not convex.
    Legacy,
    /// The surface has mass.
    Shell,
}

/// Volume (or area), centre and inertia of density 1; `None` if there is no volume. For
/// [`Rule::Convex`] the triangles are those of the hull.
pub(super) fn properties(vertices: &[Point3<f64>], triangles: &[[u32; 3]], rule: Rule) -> Option<RigidInertia> {
    let corners = || triangles.iter().map(|t| t.map(|i| vertices[i as usize].coords));
    let normal = |[a, b, c]: &[Vector3<f64>; 3]| 0.5 * (b - a).cross(&(c - a));
    let centre = |[a, b, c]: &[Vector3<f64>; 3]| (a + b + c) / 3.0;
    let area: f64 = corners().map(|t| normal(&t).norm()).sum();
    let surface: Vector3<f64> = corners().map(|t| normal(&t).norm() * centre(&t)).sum::<Vector3<f64>>() / area;
    let size = |t: &[Vector3<f64>; 3], origin: &Vector3<f64>| {
        let volume = normal(t).dot(&(centre(t) - origin)) / 3.0;
        match rule {
            Rule::Shell => normal(t).norm(),
            Rule::Legacy => volume.abs(),
            Rule::Convex | Rule::Exact => volume,
        }
    };
    let (mut total, mut first) = (0.0, Vector3::zeros());
    for t in corners() {
        let part = size(&t, &surface);
        total += part;
        first += part * if rule == Rule::Shell { centre(&t) } else { 0.75 * centre(&t) + 0.25 * surface };
    }
    let com = first / total;
    let (mut total, mut second) = (0.0, Matrix3::zeros());
    for t in corners() {
        let part = size(&t, &com);
        let [d, e, f] = t.map(|corner| corner - com);
        let sum = d + e + f;
        // 2 sum of squares + mixed products = sum of squares + square of the sum.
        let products = d * d.transpose() + e * e.transpose() + f * f.transpose() + sum * sum.transpose();
        second += products * part / if rule == Rule::Shell { 12.0 } else { 20.0 };
        total += part;
    }
    let tensor = Matrix3::identity() * second.trace() - second;
    let is_finite = total.is_finite() && com.iter().chain(tensor.iter()).all(|x| x.is_finite());
    (is_finite && total > 1e-15).then_some(RigidInertia { mass: total, com, tensor })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::spatial_hull::convex_hull_3d;

    /// A box of 2 x 4 x 6 m about (1, 2, 3).
    fn block() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let corner = |i: usize| Point3::new(2.0 * (i & 1) as f64, 4.0 * (i >> 1 & 1) as f64, 6.0 * (i >> 2) as f64);
        convex_hull_3d(&(0..8).map(corner).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_box_has_its_closed_form_by_each_rule() {
        let (vertices, triangles) = block();
        for rule in [Rule::Convex, Rule::Exact, Rule::Legacy] {
            let body = properties(&vertices, &triangles, rule).unwrap();
            let moments = Vector3::new(16.0 + 36.0, 4.0 + 36.0, 4.0 + 16.0) * 48.0 / 12.0;
            assert!((body.mass - 48.0).abs() < 1e-12, "{rule:?} {body:?}");
            assert!((body.com - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-12, "{rule:?} {body:?}");
            assert!((body.tensor - Matrix3::from_diagonal(&moments)).norm() < 1e-10, "{rule:?} {body:?}");
        }
        let body = properties(&vertices, &triangles, Rule::Shell).unwrap();
        // Faces normal to x, y, z: areas of both, plates at half the edge.
        let (x, y, z) = (48.0, 24.0, 16.0);
        let plate =
            |own: f64, at: f64, others: f64, b: f64| own * b * b / 12.0 + at * b * b / 4.0 + others * b * b / 12.0;
        let [px, py, pz] = [plate(0.0, x, y + z, 2.0), plate(0.0, y, x + z, 4.0), plate(0.0, z, x + y, 6.0)];
        assert!((body.mass - 88.0).abs() < 1e-12, "{body:?}");
        let moments = Vector3::new(py + pz, px + pz, px + py);
        assert!((body.tensor - Matrix3::from_diagonal(&moments)).norm() < 1e-10, "{body:?} {moments}");
    }

    #[test]
    fn a_flat_mesh_has_no_volume_but_a_shell() {
        let vertices = [Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
        assert!(properties(&vertices, &[[0, 1, 2]], Rule::Legacy).is_none());
        assert_eq!(properties(&vertices, &[[0, 1, 2]], Rule::Shell).unwrap().mass, 0.5);
    }
}
