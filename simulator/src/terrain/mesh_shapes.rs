//! Meshes as convex solids: one hull, or a prism below each triangle.

use super::piece::{Solid, TerrainFace, prism_faces};
use crate::geometry::spatial_hull::{convex_hull_3d, outermost, spread};
use nalgebra::{Point3, Vector3};
use std::collections::HashMap;

/// Greatest number of corners of a hull. Of more, those that reach farthest in as many directions
/// are kept.
pub const MAX_CORNERS: usize = 1000;

/// Distance from the plane of a face, relative to the size of the hull, up to which a triangle
/// belongs to it: meshes in single precision are not exactly flat.
const COPLANAR: f64 = 1e-7;

/// Volume, relative to the cube of its size, up to which a hull is flat.
const FLAT: f64 = 1e-9;

/// The convex hull of points; `None` for flat bodies. All its faces can be touched.
pub fn hull(points: &[Vector3<f64>]) -> Option<Solid> {
    let all = triangulated_hull(points)?;
    let (points, triangles) = match all.0.len() > MAX_CORNERS {
        true => triangulated_hull(&outermost(&all.0, &spread(MAX_CORNERS)))?,
        false => all,
    };
    let triangles: Vec<[u16; 3]> = triangles.iter().map(|t| t.map(|k| k as u16)).collect();
    let faces = merge_coplanar(&points, &triangles);
    Some(Solid { points, faces })
}

type VerticesAndTriangles = (Vec<Vector3<f64>>, Vec<[u32; 3]>);

fn triangulated_hull(points: &[Vector3<f64>]) -> Option<VerticesAndTriangles> {
    let input: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
    let (vertices, triangles) = convex_hull_3d(&input)?;
    let from = |k: u32| vertices[k as usize] - vertices[0];
    let size = vertices.iter().map(|p| (p - vertices[0]).norm()).fold(0.0, f64::max);
    let volume: f64 = triangles.iter().map(|t| from(t[0]).dot(&from(t[1]).cross(&from(t[2]))) / 6.0).sum();
    let has_volume = volume > FLAT * size * size * size;
    has_volume.then(|| (vertices.iter().map(|p| p.coords).collect(), triangles))
}

/// Joins neighbouring triangles in one plane to faces.
fn merge_coplanar(points: &[Vector3<f64>], triangles: &[[u16; 3]]) -> Vec<TerrainFace> {
    let point = |k: u16| points[usize::from(k)];
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let doubled_area = |t: &[u16; 3]| (point(t[1]) - point(t[0])).cross(&(point(t[2]) - point(t[0])));
    let edges = |t: &[u16; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    let mut owner: HashMap<(u16, u16), usize> = HashMap::new();
    for (i, triangle) in triangles.iter().enumerate() {
        owner.extend(edges(triangle).map(|edge| (edge, i)));
    }
    // The normal of a large triangle is the most accurate.
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&i, &j| doubled_area(&triangles[j]).norm().total_cmp(&doubled_area(&triangles[i]).norm()));
    let mut is_used = vec![false; triangles.len()];
    let mut faces = Vec::new();
    for seed in order {
        if std::mem::replace(&mut is_used[seed], true) {
            continue;
        }
        let normal = doubled_area(&triangles[seed]).try_normalize(0.0).unwrap_or_default();
        let origin = point(triangles[seed][0]);
        let is_in_plane = |t: &[u16; 3]| {
            normal.dot(&doubled_area(t)) >= 0.0
                && t.iter().all(|&k| normal.dot(&(point(k) - origin)).abs() <= COPLANAR * size)
        };
        let mut group = vec![seed];
        let mut next = 0;
        while let Some(&i) = group.get(next) {
            next += 1;
            for (a, b) in edges(&triangles[i]) {
                if let Some(&j) = owner.get(&(b, a))
                    && !is_used[j]
                    && is_in_plane(&triangles[j])
                {
                    is_used[j] = true;
                    group.push(j);
                }
            }
        }
        match outline(&group, triangles) {
            Some(corners) => faces.push(TerrainFace { corners, touchable: true }),
            None => faces.extend(group.iter().map(|&i| TerrainFace::new(&triangles[i], true))),
        }
    }
    faces
}

/// The border of a group of triangles; `None` unless it is one loop.
fn outline(group: &[usize], triangles: &[[u16; 3]]) -> Option<Vec<u16>> {
    let edges = || group.iter().flat_map(|&i| (0..3).map(move |k| (triangles[i][k], triangles[i][(k + 1) % 3])));
    let inner: std::collections::HashSet<(u16, u16)> = edges().collect();
    let mut after: HashMap<u16, u16> = HashMap::new();
    let mut first = None;
    for (a, b) in edges().filter(|(a, b)| !inner.contains(&(*b, *a))) {
        first.get_or_insert(a);
        if after.insert(a, b).is_some() {
            return None;
        }
    }
    let first = first?;
    let mut corners = vec![first];
    while let Some(next) = after.remove(corners.last()?) {
        if next == first {
            break;
        }
        corners.push(next);
    }
    after.is_empty().then_some(corners)
}

/// For each triangle, a prism from the triangle to `depth` behind it, against its normal. Only the
/// triangles themselves can be touched. Triangles without area are left out.
pub fn prisms(points: &[Vector3<f64>], triangles: &[[u32; 3]], depth: f64) -> Vec<Solid> {
    let prism = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|k| points[k as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).filter(|n| n.iter().all(|x| x.is_finite()))?;
        let down = normal * depth;
        Some(Solid { points: vec![a, b, c, a - down, b - down, c - down], faces: prism_faces([false; 3]) })
    };
    triangles.iter().filter_map(prism).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_convex, volume};
    use super::*;

    #[test]
    fn the_hull_of_a_block_has_six_faces() {
        let mut points: Vec<Vector3<f64>> =
            (0..8).map(|k| Vector3::new((k & 1) as f64, (k >> 1 & 1) as f64 * 2.0, (k >> 2) as f64 * 0.5)).collect();
        // Points of its surface and inside change nothing.
        points.extend([Vector3::new(0.5, 1.0, 0.25), Vector3::new(0.5, 0.5, 0.0)]);
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, 0.2, -0.9);
        points.iter_mut().for_each(|p| *p = turn * *p + Vector3::new(3.0, -1.0, 0.2));
        let solid = hull(&points).unwrap();
        assert_convex(&solid.points, &solid.faces, 1e-9);
        assert_eq!(solid.faces.len(), 6);
        assert!((volume(&solid.points, &solid.faces) - 1.0).abs() < 1e-9);
        assert!(hull(&points[..4]).is_none(), "a flat body has no hull");
    }

    #[test]
    fn a_ball_keeps_its_volume_within_its_greatest_number_of_corners() {
        let points: Vec<Vector3<f64>> = spread(5000).into_iter().map(|d| d * 0.5).collect();
        let solid = hull(&points).unwrap();
        assert!(solid.points.len() <= MAX_CORNERS);
        assert_convex(&solid.points, &solid.faces, 1e-6);
        let ball = std::f64::consts::PI / 6.0;
        let found = volume(&solid.points, &solid.faces);
        assert!(found < ball && found > 0.98 * ball, "{found} {ball}");
    }

    #[test]
    fn prisms_are_behind_their_triangles() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [0.0, 2.0, 0.1], [1.0, 1.0, 1.0]].map(Vector3::from);
        let triangles = [[0, 1, 2], [1, 3, 2], [0, 0, 1]];
        let solids = prisms(&points, &triangles, 0.05);
        assert_eq!(solids.len(), 2, "one has no area");
        for (solid, [a, b, c]) in solids.iter().zip(triangles.map(|t| t.map(|k| points[k as usize]))) {
            assert_convex(&solid.points, &solid.faces, 1e-12);
            let area = (b - a).cross(&(c - a)).norm() / 2.0;
            assert!((volume(&solid.points, &solid.faces) - 0.05 * area).abs() < 1e-12);
            let touchable: Vec<bool> = solid.faces.iter().map(|face| face.touchable).collect();
            assert_eq!(touchable, [true, false, false, false, false]);
            assert_eq!(solid.points[..3], [a, b, c]);
        }
    }
}
