//! Convex hulls in space, by `parry3d`, and the outermost points of large sets.

use crate::math;
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::transformation::try_convex_hull;

/// Unit vectors spread evenly over the sphere, on a spiral of golden angles.
pub fn spread(n: usize) -> Vec<Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let direction = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / n as f64;
        let (sin, cos) = math::sin_cos(golden * i as f64);
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * cos, r * sin, z)
    };
    (0..n).map(direction).collect()
}

/// The outermost point along each direction, each point once.
pub fn outermost(points: &[Vector3<f64>], directions: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut best = vec![(f64::NEG_INFINITY, 0); directions.len()];
    for (i, p) in points.iter().enumerate() {
        for (best, d) in best.iter_mut().zip(directions) {
            let reach = d.dot(p);
            if reach > best.0 {
                *best = (reach, i);
            }
        }
    }
    let mut chosen: Vec<usize> = best.into_iter().map(|(_, i)| i).collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|i| points[i]).collect()
}

/// Vertices, and triangles by the indices of their corners.
pub type VerticesAndTriangles = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// Vertices and triangles of the convex hull, triangles counter-clockwise seen from outside; `None`
/// for flat bodies.
pub fn convex_hull_3d(points: &[Point3<f64>]) -> Option<VerticesAndTriangles> {
    let input: Vec<ParryVector> = points.iter().map(|p| ParryVector::new(p.x, p.y, p.z)).collect();
    let (vertices, triangles) = try_convex_hull(&input).ok()?;
    let finite = vertices.iter().all(|p| p.x.is_finite() && p.y.is_finite() && p.z.is_finite());
    finite.then(|| (vertices.iter().map(|p| Point3::new(p.x, p.y, p.z)).collect(), triangles))
}
