//! A link as a convex polyhedron that may touch the floor.
//!
//! On a plane the union of convex shapes of a link touches where its convex hull does, so one hull
//! per link suffices. With points p_k of the hull in the link's frame, and n the floor's normal,
//! the heights and their rates are those of points of a rigid body,
//!
//! ```text
//! h_k = n . (o + R p_k - f)        dh_k/dt = n . (v + omega x R p_k)
//! ```
//!
//! The points that touch lie in one face, edge or corner, as the plane supports the hull. The
//! polygon that may touch next is therefore a face with the lowest point.

use super::Floor;
use super::sunk_links::is_point_near_soles;
use crate::collision::spatial::shape_points;
use crate::dynamics::Workspace;
use crate::geometry::{Plane, convex_hull, convex_hull_3d};
use crate::robot::{Base, Geometry, LinkId, Model, Shape};
use nalgebra::{Matrix3, Point3, Vector3};

/// Greatest number of corners of a face.
pub const MAX_CORNERS: usize = 64;

/// Distance from the plane of a face, relative to the size of the hull, up to which a point belongs
/// to it.
const COPLANAR: f64 = 1e-9;

/// A flat face: indices of its corners, in order around it, and its outward normal. Hulls without
/// volume have one face, whose normal has either sign or is zero.
#[derive(Clone, Debug)]
pub struct Face {
    /// Indices into the points of the hull.
    pub corners: Vec<u16>,
    normal: Vector3<f64>,
}

/// The convex hull of a link's collision shapes, in the link's internal frame.
#[derive(Clone, Debug)]
pub struct LinkHull {
    /// The link.
    pub link: LinkId,
    /// Corners, m.
    pub points: Vec<Vector3<f64>>,
    /// Faces.
    pub faces: Vec<Face>,
    /// The box along the link's axes around the points: its centre and half its sizes, m.
    centre: Vector3<f64>,
    half: Vector3<f64>,
    /// Greatest distance of a point from that centre and from the link's origin, m.
    radius: f64,
    reach: f64,
}

/// Distance of a sole's vertex from the surface of a ball, m, up to which the sole stands for the ball.
const ON_BALL: f64 = 1e-3;

/// Whether a shape is a ball with the point on its surface.
pub fn is_on_ball(shape: &Shape, point: &Vector3<f64>) -> bool {
    let Geometry::Sphere(radius) = shape.geometry else { return false };
    ((point - shape.pose.translation.vector).norm() - radius).abs() < ON_BALL
}

/// Whether a shape is the ball of a point foot.
fn is_foot(model: &Model, link: LinkId, shape: &Shape) -> bool {
    let mut vertices = model.soles.iter().filter(|sole| sole.link == link).flat_map(|sole| &sole.vertices);
    vertices.any(|v| is_on_ball(shape, v))
}

impl LinkHull {
    /// The hulls of all links with collision shapes. Points near a sole of their link are left out, and balls
    /// with a vertex of a sole on their surface: the sole stands for them. `resolution` is the number of corners
    /// to a circle. Shapes for which `leave` holds are left out, and the root of a fixed base, which cannot move.
    pub fn of_model(model: &Model, resolution: usize, leave: impl Fn(LinkId, &Shape) -> bool) -> Vec<Self> {
        let moving = usize::from(model.base == Base::Fixed)..model.links.len();
        moving.filter_map(|link| Self::of_link(model, LinkId(link), resolution, &leave)).collect()
    }

    fn of_link(
        model: &Model,
        link: LinkId,
        resolution: usize,
        leave: &impl Fn(LinkId, &Shape) -> bool,
    ) -> Option<Self> {
        let shapes = model.links[link.0].collisions.iter();
        let shapes = shapes.filter(|shape| !leave(link, shape) && !is_foot(model, link, shape));
        let mut points: Vec<Vector3<f64>> = shapes.flat_map(|shape| shape_points(shape, resolution)).collect();
        points.retain(|point| !is_point_near_soles(model, link, point));
        let (points, faces) = hull(points)?;
        let (mut least, mut greatest) = (points[0], points[0]);
        points.iter().for_each(|p| (least, greatest) = (least.inf(p), greatest.sup(p)));
        let (centre, half) = ((greatest + least) / 2.0, (greatest - least) / 2.0);
        let distance = |from: Vector3<f64>| points.iter().map(|p| (p - from).norm()).fold(0.0, f64::max);
        let (radius, reach) = (distance(centre), distance(Vector3::zeros()));
        Some(LinkHull { link, points, faces, centre, half, radius, reach })
    }

    /// Heights above the floor, m: a lower bound for all points, of no more than a few operations.
    /// Needs `kinematics::update`.
    pub fn bound(&self, ws: &Workspace, floor: &Floor) -> f64 {
        let origin = floor.height(&(ws.position + ws.links[self.link.0].origin));
        if origin > self.reach {
            return origin - self.reach;
        }
        let up = self.up(ws, floor);
        origin + up.dot(&self.centre) - up.abs().dot(&self.half)
    }

    /// Calls `f` with each point and its height above the floor after a time `ahead`, s, at its present
    /// velocity, m. Needs `kinematics::update`.
    pub fn heights(&self, ws: &Workspace, floor: &Floor, ahead: f64, mut f: impl FnMut(usize, f64)) {
        let link = &ws.links[self.link.0];
        let normal: Vector3<f64> = floor.rotation.column(2).into();
        let up = link.rotation.tr_mul(&normal);
        let origin = floor.height(&(ws.position + link.origin));
        if ahead == 0.0 {
            self.points.iter().enumerate().for_each(|(k, p)| f(k, origin + up.dot(p)));
            return;
        }
        // n . (v + omega x R p) = n . v + (R^T (n x omega)) . p
        let rise = normal.dot(&link.velocity.at(&link.origin));
        let turn = link.rotation.tr_mul(&normal.cross(&link.velocity.angular));
        let (origin, up) = (origin + ahead * rise, up + turn * ahead);
        self.points.iter().enumerate().for_each(|(k, p)| f(k, origin + up.dot(p)));
    }

    /// The floor's normal in the link's internal frame.
    fn up(&self, ws: &Workspace, floor: &Floor) -> Vector3<f64> {
        ws.links[self.link.0].rotation.tr_mul(&floor.rotation.column(2))
    }

    /// Greatest speed of a point, m/s.
    pub fn fastest(&self, ws: &Workspace) -> f64 {
        let link = &ws.links[self.link.0];
        let centre = link.origin + link.rotation * self.centre;
        link.velocity.at(&centre).norm() + link.velocity.angular.norm() * self.radius
    }

    /// The face that may touch next: it has the lowest point and most of the `near` ones. Of several
    /// the `present` one if it is among them, otherwise that which faces the floor most.
    pub fn face(
        &self,
        lowest: u16,
        near: impl Fn(u16) -> bool,
        present: &[u16],
        ws: &Workspace,
        floor: &Floor,
    ) -> Option<&Face> {
        let up = self.up(ws, floor);
        let key = |face: &Face| {
            let count = face.corners.iter().filter(|&&k| near(k)).count();
            (count, face.corners == present, -face.normal.dot(&up))
        };
        let faces = self.faces.iter().filter(|face| face.corners.contains(&lowest));
        faces.max_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2))
        })
    }
}

/// Corners and faces of the convex hull of points; `None` without points.
fn hull(points: Vec<Vector3<f64>>) -> Option<(Vec<Vector3<f64>>, Vec<Face>)> {
    let first = *points.first()?;
    let size = points.iter().map(|p| (p - first).norm()).fold(0.0, f64::max);
    let input: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
    let Some((vertices, triangles)) = convex_hull_3d(&input) else {
        let (corners, normal) = flat_hull(&points, first, size);
        let face = Face { corners: (0..corners.len() as u16).collect(), normal };
        return Some((corners, vec![face]));
    };
    let vertices: Vec<Vector3<f64>> = vertices.iter().map(|p| p.coords).collect();
    let (mut corners, mut faces): (Vec<Vector3<f64>>, Vec<Face>) = (Vec::new(), Vec::new());
    for triangle in triangles {
        let [a, b, c] = triangle.map(|k| vertices[k as usize]);
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
        let mut face: Vec<Vector3<f64>> =
            vertices.iter().filter(|p| normal.dot(&(**p - a)).abs() <= COPLANAR * size).copied().collect();
        outline(&mut face, &normal);
        let indices: Vec<u16> = face.iter().map(|p| index(&mut corners, p)).collect();
        let is_known = faces.iter().any(|known| indices.iter().all(|k| known.corners.contains(k)));
        if indices.len() > 2 && !is_known {
            faces.push(Face { corners: indices, normal });
        }
    }
    (!faces.is_empty()).then_some((corners, faces))
}

/// Corners and normal of points without volume.
fn flat_hull(points: &[Vector3<f64>], first: Vector3<f64>, size: f64) -> (Vec<Vector3<f64>>, Vector3<f64>) {
    let by_norm = |a: &Vector3<f64>, b: &Vector3<f64>| a.norm_squared().total_cmp(&b.norm_squared());
    let far = points.iter().map(|p| p - first).max_by(by_norm).unwrap_or_default();
    let normal = points.iter().map(|p| far.cross(&(p - first))).max_by(by_norm).unwrap_or_default();
    if normal.norm() > COPLANAR * size * size {
        let (normal, mut face) = (normal.normalize(), points.to_vec());
        outline(&mut face, &normal);
        return (face, normal);
    }
    // On a line, or one point.
    let along = |p: &Vector3<f64>| far.dot(p);
    let ends = [
        points.iter().min_by(|a, b| along(a).total_cmp(&along(b))),
        points.iter().max_by(|a, b| along(a).total_cmp(&along(b))),
    ];
    let mut ends: Vec<Vector3<f64>> = ends.into_iter().flatten().copied().collect();
    ends.dedup();
    (ends, Vector3::zeros())
}

/// Replaces coplanar points by the corners of their outline, at most [`MAX_CORNERS`], in order around
/// `normal`.
fn outline(points: &mut Vec<Vector3<f64>>, normal: &Vector3<f64>) {
    let across = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let rotation = Matrix3::from_columns(&[across, normal.cross(&across), *normal]);
    convex_hull(points, &Plane { rotation, point: points[0] });
    if points.len() > MAX_CORNERS {
        let all = std::mem::take(points);
        points.extend((0..MAX_CORNERS).map(|k| all[k * all.len() / MAX_CORNERS]));
    }
}

/// Index of a point, which is added if it is new.
fn index(corners: &mut Vec<Vector3<f64>>, p: &Vector3<f64>) -> u16 {
    let at = corners.iter().position(|corner| corner == p).unwrap_or_else(|| {
        corners.push(*p);
        corners.len() - 1
    });
    at as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(skip: impl Fn(usize) -> bool) -> Vec<Vector3<f64>> {
        let corner = |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { 1.0 } else { -1.0 });
        (0..8).filter(|&k| !skip(k)).map(corner).collect()
    }

    #[test]
    fn a_cube_has_six_faces_of_four_corners_and_points_inside_are_dropped() {
        let mut points = cube(|_| false);
        points.extend([Vector3::new(0.1, 0.2, 0.3), Vector3::new(1.0, 0.0, 0.0), Vector3::new(1.0, 1.0, 0.5)]);
        let (corners, faces) = hull(points).unwrap();
        assert_eq!((corners.len(), faces.len()), (8, 6));
        for face in &faces {
            let ring: Vec<_> = face.corners.iter().map(|k| corners[*k as usize]).collect();
            assert_eq!(ring.len(), 4);
            // Sides of length 2, counter-clockwise seen from outside.
            for i in 0..4 {
                let (a, b, c) = (ring[i], ring[(i + 1) % 4], ring[(i + 2) % 4]);
                assert_eq!((b - a).norm(), 2.0);
                assert!((b - a).cross(&(c - b)).dot(&face.normal) > 0.0);
            }
            assert!((face.normal.dot(&ring[0]) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn points_without_volume_have_one_face() {
        // The upper four corners, two of them, one; and none.
        for (skip, corners) in [(0x0f, 4), (0xcf, 2), (0x7f, 1)] {
            let (points, faces) = hull(cube(|k| skip >> k & 1 == 1)).unwrap();
            assert_eq!((points.len(), faces.len(), faces[0].corners.len()), (corners, 1, corners), "{skip:x}");
        }
        assert!(hull(Vec::new()).is_none());
    }
}
