//! Random polyhedra and poses, and brute-force geometry of pairs.

use nalgebra::{Matrix3, Rotation3, Vector3};
use stiction::collision::detection::Detector;
use stiction::collision::spatial::{Polytope, Search};
use stiction::collision::{Body, CollisionModel, LinkPose, Pair, Proximity};
use stiction::random::Stream;
use stiction::robot::LinkId;

/// The hull of `n` points about an ellipsoid, or of a box and `n` points in it for even cases:
/// slivers as well as rectangles.
pub fn polytope(r: &mut Stream, n: usize) -> Polytope {
    let half = Vector3::from_fn(|_, _| 0.02 + 0.2 * r.unit());
    let boxy = r.below(2) == 0;
    let mut points: Vec<Vector3<f64>> = Vec::new();
    if boxy {
        points.extend((0..8).map(|k| Vector3::from_fn(|i, _| if k >> i & 1 == 1 { half[i] } else { -half[i] })));
    }
    for _ in 0..n {
        let p = Vector3::from_fn(|_, _| r.normal());
        let on_ball = p / p.norm();
        points.push(half.component_mul(&if boxy { on_ball * 0.5 } else { on_ball }));
    }
    Polytope::hull(&points).expect("not flat")
}

/// A random pose, its origin within `reach` of 0 along each axis.
pub fn pose(r: &mut Stream, reach: f64) -> LinkPose {
    let turn = Vector3::from_fn(|_, _| 2.0 * r.normal());
    LinkPose {
        rotation: Rotation3::new(turn).into_inner(),
        origin: Vector3::from_fn(|_, _| reach * (2.0 * r.unit() - 1.0)),
    }
}

/// Polyhedra as bodies on links 0, 1, 2, ... with every pair monitored.
pub fn model(polytopes: Vec<Polytope>) -> CollisionModel {
    let n = polytopes.len();
    let bodies = polytopes.into_iter().enumerate();
    let bodies = bodies.map(|(i, polytope)| Body { link: LinkId(i), name: format!("body {i}"), polytope }).collect();
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |k| Pair { bodies: [i, k], joints: vec![] })).collect();
    CollisionModel { bodies, pairs, dropped_bodies: vec![], dropped_pairs: vec![], search: Search::default() }
}

/// The only pair of a model of two bodies.
pub fn single(model: &CollisionModel, poses: &[LinkPose]) -> Proximity {
    let mut detector = Detector::new(model);
    detector.set_poses(model, poses);
    detector.distances(model)[0]
}

/// Vertices of a body in its pose.
pub fn placed(body: &Body, poses: &[LinkPose]) -> Vec<Vector3<f64>> {
    body.polytope.vertices.iter().map(|p| poses[body.link.0].point(p)).collect()
}

/// Distance of the bodies along a unit vector from the first to the second; negative: overlap.
pub fn apart_along(n: &Vector3<f64>, a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let least = b.iter().map(|p| n.dot(p)).fold(f64::INFINITY, f64::min);
    let greatest = a.iter().map(|p| n.dot(p)).fold(f64::NEG_INFINITY, f64::max);
    least - greatest
}

/// Whether a point, in the frame of the poses, is in the body, up to `margin`.
pub fn holds(body: &Body, poses: &[LinkPose], p: &Vector3<f64>, margin: f64) -> bool {
    let pose = &poses[body.link.0];
    body.polytope.contains(&pose.rotation.tr_mul(&(p - pose.origin)), margin)
}

/// Normals of the triangles and directions of their edges, in the frame of the poses.
pub fn normals_and_edges(body: &Body, poses: &[LinkPose]) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let turn: Matrix3<f64> = poses[body.link.0].rotation;
    let (mut normals, mut edges) = (Vec::new(), Vec::new());
    for t in &body.polytope.triangles {
        let [a, b, c] = t.map(|k| turn * body.polytope.vertices[k as usize]);
        normals.push((b - a).cross(&(c - a)).normalize());
        // Each edge belongs to two triangles and is taken from one of them.
        let own = [(t[0], t[1], b - a), (t[1], t[2], c - b), (t[2], t[0], a - c)];
        edges.extend(own.iter().filter(|(i, k, _)| i < k).map(|(_, _, edge)| edge.normalize()));
    }
    (normals, edges)
}
