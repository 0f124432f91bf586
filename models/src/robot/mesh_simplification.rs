//! Replaces meshes of many triangles by convex hulls, so that logs stay small.

use nalgebra::{Point3, Vector3};

use super::model::{Geometry, Model};
use super::notices::Notices;
use super::xml_syntax::root_element;
use crate::geometry::spatial_hull::{convex_hull_3d, outermost, spread};
use crate::text::source::Source;

/// Greatest number of triangles of a mesh that is not replaced.
const MAX_TRIANGLES: usize = 1000;
/// Directions along which the outermost vertices of a larger mesh are kept: about 14 degrees apart,
/// so the hull of a ball of radius r is at most 0.8 % of r within it, and that of a body with few
/// corners is exact.
pub(super) const DIRECTIONS: usize = 200;

/// Replaces large meshes by hulls of their outermost vertices, with a notice.
pub(super) fn simplify_meshes(model: &mut Model, source: &Source, notices: &mut Notices) {
    let directions = spread(DIRECTIONS);
    let shapes = model.links.iter_mut().flat_map(|l| l.visuals.iter_mut().chain(&mut l.collisions));
    let (mut replaced, mut before) = (0, 0);
    for shape in shapes {
        let Geometry::Mesh(points, triangles) = &shape.geometry else { continue };
        if triangles.len() <= MAX_TRIANGLES {
            continue;
        }
        // A flat mesh has no hull and stays.
        let points: Vec<Vector3<f64>> = points.iter().map(|p| p.coords).collect();
        let Some(hull) = hull(&outermost(&points, &directions)) else { continue };
        (replaced, before) = (replaced + 1, before + triangles.len());
        shape.geometry = hull;
    }
    if replaced > 0 {
        let message = format!(
            "{replaced} meshes of more than {MAX_TRIANGLES} triangles ({before} in all) are kept as convex hulls"
        );
        notices.info(source, root_element(source), message);
    }
}

fn hull(points: &[Vector3<f64>]) -> Option<Geometry> {
    let points: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
    convex_hull_3d(&points).map(|(vertices, triangles)| Geometry::Mesh(vertices, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_of_many_vertices_loses_less_than_a_hundredth() {
        let points: Vec<Vector3<f64>> = spread(20_000).into_iter().map(|d| 2.0 * d).collect();
        let Some(Geometry::Mesh(vertices, triangles)) = hull(&outermost(&points, &spread(DIRECTIONS))) else {
            panic!("no hull")
        };
        assert!(vertices.len() <= DIRECTIONS && triangles.len() == 2 * vertices.len() - 4, "Euler's formula");
        for t in &triangles {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            let normal = (b - a).cross(&(c - a)).normalize();
            assert!(normal.dot(&a.coords) > 2.0 * 0.98, "{}", normal.dot(&a.coords));
        }
    }

    #[test]
    fn a_block_of_many_vertices_keeps_its_corners() {
        let points: Vec<Vector3<f64>> =
            spread(5_000).into_iter().map(|d| 0.5 * d / d.amax()).chain(corners().map(|c| c.coords)).collect();
        let Some(Geometry::Mesh(vertices, _)) = hull(&outermost(&points, &spread(DIRECTIONS))) else {
            panic!("no hull")
        };
        for corner in corners() {
            assert!(vertices.contains(&corner), "{corner}");
        }
    }

    fn corners() -> impl Iterator<Item = Point3<f64>> {
        (0..8).map(|i| Point3::from(Vector3::from_fn(|axis, _| if i >> axis & 1 == 1 { 0.5 } else { -0.5 })))
    }
}
