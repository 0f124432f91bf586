//! Links below the floor, of robots of which only soles touch it.
//!
//! The collision shapes of a link are convex hulls of balls (corners, with radius 0, spheres, the
//! ends of capsules) and discs (the ends of cylinders). With the floor's normal n, the lowest points
//! of a ball about c, and of a disc with unit axis a, are at the heights
//!
//! ```text
//! ball: n . c - r        disc: n . c - r |n x a|
//! ```
//!
//! (support functions, [van den Bergen 2004, section 4.3.2]).
//!
//! A sole may be smaller than the bottom of its foot, and round feet have a point as sole. Balls and
//! discs of a link that come within 1 cm of one of its soles are therefore left out. What is farther
//! from the sole is below the floor only if the link lies on its side.

use super::Floor;
use crate::dynamics::Workspace;
use crate::geometry::convex_hull_3d;
use crate::robot::model::Sole;
use crate::robot::{Base, Geometry, Link, LinkId, Model, Shape};
use nalgebra::{Point3, Vector3};

/// Depth below the floor from which a link has sunk, m.
const SUNK: f64 = 1e-3;

/// Distance from a sole up to which a ball or disc is left out, m.
const NEAR_SOLE: f64 = 0.01;

/// A ball, or a disc if it has an axis; in the link's internal frame.
#[derive(Clone, Debug)]
struct Round {
    centre: Vector3<f64>,
    radius: f64,
    axis: Option<Vector3<f64>>,
}

impl Round {
    /// Distance of its lowest point from the centre, along the unit vector `up` of the link's frame,
    /// m.
    fn reach(&self, up: &Vector3<f64>) -> f64 {
        self.axis.map_or(self.radius, |axis| self.radius * up.cross(&axis).norm())
    }

    /// Whether it comes near to a sole.
    fn is_near(&self, sole: &Sole) -> bool {
        is_near_sole(sole, &self.centre, |normal| self.reach(normal), self.radius)
    }
}

/// Whether a convex part of a link about `centre` comes near to a sole: to its plane, or to the points
/// of one without a plane. `reach` is its extent along a direction, `radius` the greatest.
fn is_near_sole(sole: &Sole, centre: &Vector3<f64>, reach: impl Fn(&Vector3<f64>) -> f64, radius: f64) -> bool {
    let middle = sole.centroid();
    let side = |i: usize| sole.vertices[i] - middle;
    let normal = (2..sole.vertices.len())
        .map(|i| side(0).cross(&side(i)))
        .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
        .and_then(|normal| normal.try_normalize(0.0));
    match normal {
        Some(normal) => normal.dot(&(centre - middle)).abs() - reach(&normal) <= NEAR_SOLE,
        None => sole.vertices.iter().any(|v| (centre - v).norm() - radius <= NEAR_SOLE),
    }
}

/// Whether a part of a link's shape comes near to a sole of the link.
pub fn is_near(sole: &Sole, shape: &Shape) -> bool {
    rounds(shape).iter().any(|part| part.is_near(sole))
}

/// Whether a point of a link is near to one of the link's soles.
pub(super) fn is_point_near_soles(model: &Model, link: LinkId, point: &Vector3<f64>) -> bool {
    model.soles.iter().any(|sole| sole.link == link && is_near_sole(sole, point, |_| 0.0, 0.0))
}

/// Balls and discs of one link, and a ball around them.
#[derive(Clone, Debug)]
struct LinkRounds {
    link: LinkId,
    parts: Vec<Round>,
    centre: Vector3<f64>,
    radius: f64,
}

/// The links of a robot that can sink through the floor.
#[derive(Clone, Debug)]
pub struct SunkLinks(Vec<LinkRounds>);

impl SunkLinks {
    /// The links with collision shapes. None without soles, as the floor then has no meaning, and
    /// none of a fixed base, which cannot fall.
    pub fn new(model: &Model) -> Self {
        if model.base == Base::Fixed || model.soles.is_empty() {
            return SunkLinks(Vec::new());
        }
        let rounds = |(i, link): (usize, &Link)| {
            let mut parts: Vec<Round> = link.collisions.iter().flat_map(rounds).collect();
            let soles = || model.soles.iter().filter(|sole| sole.link == LinkId(i));
            parts.retain(|part| !soles().any(|sole| part.is_near(sole)));
            let centre = parts.iter().map(|part| part.centre).sum::<Vector3<f64>>() / parts.len() as f64;
            let radius = parts.iter().map(|part| (part.centre - centre).norm() + part.radius).fold(0.0, f64::max);
            (!parts.is_empty()).then_some(LinkRounds { link: LinkId(i), parts, centre, radius })
        };
        SunkLinks(model.links.iter().enumerate().filter_map(rounds).collect())
    }

    /// The deepest link that has sunk, with its depth, m. Needs `kinematics::update`.
    pub fn deepest(&self, ws: &Workspace, floor: &Floor) -> Option<(LinkId, f64)> {
        let normal: Vector3<f64> = floor.rotation.column(2).into();
        let depth = |body: &LinkRounds| {
            let link = &ws.links[body.link.0];
            let up = link.rotation.tr_mul(&normal);
            let origin = floor.height(&(ws.position + link.origin));
            if origin + up.dot(&body.centre) >= body.radius {
                return f64::NEG_INFINITY;
            }
            let lowest = |part: &Round| part.reach(&up) - up.dot(&part.centre);
            body.parts.iter().map(lowest).fold(f64::NEG_INFINITY, f64::max) - origin
        };
        let sunk = self.0.iter().map(|body| (body.link, depth(body))).filter(|(_, depth)| *depth > SUNK);
        sunk.max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Balls and discs whose convex hull is the shape's.
fn rounds(shape: &Shape) -> Vec<Round> {
    let at = |p: Vector3<f64>| (shape.pose * Point3::from(p)).coords;
    let ball = |p: Vector3<f64>, radius: f64| Round { centre: at(p), radius, axis: None };
    let ends = |length: f64| [-0.5, 0.5].map(|end| Vector3::new(0.0, 0.0, end * length));
    match &shape.geometry {
        Geometry::Box(size) => {
            let sign = |k: usize, axis: usize| if k >> axis & 1 == 1 { 0.5 } else { -0.5 };
            (0..8).map(|k| ball(Vector3::from_fn(|axis, _| sign(k, axis) * size[axis]), 0.0)).collect()
        }
        Geometry::Cylinder(radius, length) => {
            let axis = Some(shape.pose.rotation * Vector3::z());
            ends(*length).map(|end| Round { axis, ..ball(end, *radius) }).to_vec()
        }
        Geometry::Capsule(radius, length) => ends(*length).map(|end| ball(end, *radius)).to_vec(),
        Geometry::Sphere(radius) => vec![ball(Vector3::zeros(), *radius)],
        Geometry::Mesh(vertices, _) => {
            let hull = convex_hull_3d(vertices).map(|(hull, _)| hull);
            hull.as_ref().unwrap_or(vertices).iter().map(|p| ball(p.coords, 0.0)).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Translation3, UnitQuaternion};

    /// Against the support functions of shapes as URDF defines them, in their own axes.
    #[test]
    fn the_lowest_points_of_shapes() {
        let turn = UnitQuaternion::from_euler_angles(0.7, -0.4, 1.9);
        let pose = Isometry3::from_parts(Translation3::new(0.1, -0.2, 0.3), turn);
        let mesh = vec![[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1], [0.05, 0.05, 0.02]];
        let mesh = mesh.into_iter().map(Point3::from).collect();
        let up = Vector3::new(0.3, -0.5, 0.8).normalize();
        let (s, c) = crate::math::sin_cos(0.2);
        for geometry in [
            Geometry::Box(Vector3::new(0.1, 0.2, 0.3)),
            Geometry::Cylinder(0.1, 0.3),
            Geometry::Capsule(0.1, 0.3),
            Geometry::Sphere(0.1),
            Geometry::Mesh(mesh, Vec::new()),
        ] {
            let d = turn.inverse() * up;
            let flat = crate::math::hypot(d.x, d.y);
            let expected = 0.3 * up.z + 0.1 * up.x
                - 0.2 * up.y
                - match &geometry {
                    Geometry::Box(size) => 0.5 * size.dot(&d.abs()),
                    Geometry::Cylinder(r, l) => r * flat + 0.5 * l * d.z.abs(),
                    Geometry::Capsule(r, l) => r + 0.5 * l * d.z.abs(),
                    Geometry::Sphere(r) => *r,
                    Geometry::Mesh(points, _) => points.iter().map(|p| -d.dot(&p.coords)).fold(f64::MIN, f64::max),
                };
            let shape = Shape { pose, geometry, rgba: [0.0; 4] };
            let lowest = rounds(&shape).iter().map(|r| up.dot(&r.centre) - r.reach(&up)).fold(f64::MAX, f64::min);
            // One rounding of coordinates of order 1.
            assert!((lowest - expected).abs() < 1e-15, "{:?}: {lowest} {expected}", shape.geometry);
        }
        // A disc that leans by 0.2 rad.
        let disc = Round { centre: Vector3::zeros(), radius: 2.0, axis: Some(Vector3::new(s, 0.0, c)) };
        assert!((disc.reach(&Vector3::z()) - 2.0 * s).abs() < 1e-15);
    }

    #[test]
    fn parts_near_a_sole_are_left_out() {
        let sole = |vertices: &[[f64; 3]]| Sole {
            name: "sole".into(),
            link: LinkId(0),
            vertices: vertices.iter().map(|v| Vector3::from(*v)).collect(),
        };
        let face = sole(&[[0.1, 0.1, 0.0], [-0.1, 0.1, 0.0], [-0.1, -0.1, 0.0], [0.1, -0.1, 0.0]]);
        let line = sole(&[[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]]);
        let ball = |x: f64, z: f64, radius: f64| Round { centre: Vector3::new(x, 0.0, z), radius, axis: None };
        for (part, near_face, near_line) in [
            // Beside the face, in its plane; above it; a ball whose lowest point is near.
            (ball(0.5, 0.005, 0.0), true, false),
            (ball(0.0, 0.011, 0.0), false, false),
            (ball(0.1, 0.05, 0.041), true, true),
        ] {
            assert_eq!((part.is_near(&face), part.is_near(&line)), (near_face, near_line), "{part:?}");
        }
        let upright = Round { centre: Vector3::new(0.0, 0.0, 0.05), radius: 1.0, axis: Some(Vector3::z()) };
        assert!(!upright.is_near(&face), "a disc parallel to the sole, 5 cm above it");
        let lying = Round { axis: Some(Vector3::x()), ..upright };
        assert!(lying.is_near(&face), "a disc that stands on its rim");
    }
}
