//! Distances of separated bodies: bounds from both sides, and closed forms.

use super::random_bodies::{apart_along, holds, model, placed, polytope, pose, single};
use nalgebra::{Isometry3, Matrix3, Rotation3, Vector3};
use stiction::collision::spatial::Polytope;
use stiction::collision::{CollisionModel, LinkPose};
use stiction::random::Stream;
use stiction::robot::{Geometry, Shape};

/// Rounding in coordinates of about 1 m, and termination of the iteration at 1e-12 m.
const BAR: f64 = 1e-11;

/// Proves a distance. The nearest points are in their bodies, so the distance is at most theirs. No
/// vertex of either body is between the two planes across the normal through them, so it is at
/// least that.
#[test]
fn distances_of_random_polyhedra_are_proved_by_bounds() {
    let mut r = Stream::new(7, &["distance"]);
    let (mut apart, mut overlapping) = (0, 0);
    for case in 0..6_000u64 {
        let sizes = [4 + r.below(60) as usize, 4 + r.below(60) as usize];
        let m = model(vec![polytope(&mut r, sizes[0]), polytope(&mut r, sizes[1])]);
        let poses = [pose(&mut r, 0.3), pose(&mut r, 0.3)];
        let found = single(&m, &poses);
        let [a, b] = [0, 1].map(|i| placed(&m.bodies[i], &poses));
        assert!((found.normal.norm() - 1.0).abs() < 1e-12, "case {case}");
        assert!((found.on_a + found.normal * found.distance - found.on_b).norm() < BAR, "case {case}");
        let lower = apart_along(&found.normal, &a, &b);
        assert!((lower - found.distance).abs() < BAR, "case {case}: {} but {lower}", found.distance);
        if found.distance > 0.0 {
            apart += 1;
            assert!(holds(&m.bodies[0], &poses, &found.on_a, BAR), "case {case}");
            assert!(holds(&m.bodies[1], &poses, &found.on_b, BAR), "case {case}");
        } else {
            overlapping += 1;
        }
    }
    assert!(apart > 2_000 && overlapping > 1_000, "{apart} {overlapping}");
}

fn block(half: Vector3<f64>) -> Polytope {
    let corners = (0..8).map(|k| Vector3::from_fn(|i, _| if k >> i & 1 == 1 { half[i] } else { -half[i] }));
    Polytope::hull(&corners.collect::<Vec<_>>()).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> LinkPose {
    LinkPose { origin: Vector3::new(x, y, z), ..LinkPose::IDENTITY }
}

#[test]
fn blocks_side_by_side_are_apart_by_the_gap_between_them() {
    let (h, k) = (Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.05, 0.4, 0.15));
    let m = model(vec![block(h), block(k)]);
    let mut r = Stream::new(2, &["blocks"]);
    for _ in 0..2_000 {
        let p = Vector3::from_fn(|_, _| 1.2 * (2.0 * r.unit() - 1.0));
        // The whole scene rotated at random: faces, edges and corners face each other in any
        // direction.
        let whole = pose(&mut r, 0.5);
        let second = LinkPose { rotation: whole.rotation, origin: whole.point(&p) };
        let gap = p.abs() - (h + k);
        // Without overlap: the open part of the gap. With overlap: the shortest of the three ways
        // out.
        let want = if gap.max() > 0.0 { gap.map(|x| x.max(0.0)).norm() } else { gap.max() };
        let found = single(&m, &[whole, second]).distance;
        assert!((found - want).abs() < BAR, "{found} instead of {want} at {p:?}");
    }
}

#[test]
fn a_corner_above_a_face_is_its_height_apart() {
    // A cube on its corner: the corner is half the space diagonal below the centre.
    let (to, up) = (Vector3::new(1.0, 1.0, 1.0).normalize(), Vector3::z());
    let turn = Rotation3::rotation_between(&to, &-up).unwrap().into_inner();
    let m = model(vec![block(Vector3::new(1.0, 1.0, 0.1)), block(Vector3::repeat(0.1))]);
    for height in [0.3, 0.1 + 0.1 * 3f64.sqrt() + 1e-6, 0.1 + 0.1 * 3f64.sqrt() - 1e-6] {
        let cube = LinkPose { rotation: turn, origin: Vector3::new(0.2, -0.3, height) };
        let want = height - 0.1 - 0.1 * 3f64.sqrt();
        assert!((single(&m, &[at(0.0, 0.0, 0.0), cube]).distance - want).abs() < BAR);
    }
}

/// A shape as a body, with the program's own tessellation.
fn shape(geometry: Geometry, resolution: usize) -> Polytope {
    let mut robot =
        stiction::robot::load(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/rod/rod.toml")).unwrap();
    robot.model.links[0].collisions = vec![Shape { pose: Isometry3::identity(), geometry, rgba: [0.0; 4] }];
    robot.self_collision.resolution = resolution;
    CollisionModel::every_pair(&robot.model, &robot.self_collision).bodies[0].polytope.clone()
}

/// No point of the round shape is outside the polyhedron, and no vertex is farther out than the
/// bound of docs/self-collision.md.
#[test]
fn round_shapes_are_enclosed_closely() {
    let (radius, length) = (0.05, 0.2);
    for n in [8, 16, 21, 64] {
        let over = 1.0 / (std::f64::consts::PI / n as f64).cos();
        let bodies = [
            (shape(Geometry::Sphere(radius), n), 0.0, over * over),
            (shape(Geometry::Capsule(radius, length), n), length / 2.0, over * over),
        ];
        let mut r = Stream::new(n as u64, &["round"]);
        for (body, half, most) in &bodies {
            // A point of the surface in a random direction.
            for _ in 0..2_000 {
                let d = Vector3::from_fn(|_, _| r.normal()).normalize();
                let p = d * radius + Vector3::z() * d.z.signum() * *half;
                assert!(body.contains(&p, 1e-12), "{n}: {p:?}");
            }
            let out = |p: &Vector3<f64>| (p - Vector3::z() * p.z.clamp(-half, *half)).norm() / radius;
            let farthest = body.vertices.iter().map(out).fold(0.0, f64::max);
            // There are ceil(n / 4) bands per quarter, so they are no flatter than the sides: the
            // documented bound.
            assert!(farthest > 1.0 && farthest <= most + 1e-12, "{n}: {farthest} against {most}");
        }
        let cylinder = shape(Geometry::Cylinder(radius, length), n);
        for _ in 0..2_000 {
            let angle = 7.0 * r.unit();
            let p = Vector3::new(radius * angle.cos(), radius * angle.sin(), length * (r.unit() - 0.5));
            assert!(cylinder.contains(&p, 1e-12));
        }
        assert!(cylinder.vertices.iter().all(|p| (p.xy().norm() - radius * over).abs() < 1e-15));
    }
}

/// The distance is between that of the exact balls and that plus the error of the tessellation.
#[test]
fn the_distance_of_balls_is_that_of_their_centres_less_the_radii() {
    let (a, b) = (0.06, 0.11);
    let m = model(vec![shape(Geometry::Sphere(a), 32), shape(Geometry::Sphere(b), 32)]);
    let over = 1.0 / (std::f64::consts::PI / 32.0).cos().powi(2);
    let mut r = Stream::new(5, &["balls"]);
    for _ in 0..500 {
        let poses = [pose(&mut r, 0.4), pose(&mut r, 0.4)];
        let centres = (poses[0].origin - poses[1].origin).norm();
        let found = single(&m, &poses).distance;
        assert!(found <= centres - a - b + BAR && found >= centres - over * (a + b) - BAR, "{found} {centres}");
    }
}

#[test]
fn touching_bodies_have_zero_distance_to_rounding() {
    let m = model(vec![block(Vector3::repeat(0.1)), block(Vector3::repeat(0.1))]);
    for (x, y, z) in [(0.2, 0.0, 0.0), (0.2, 0.05, -0.03), (0.2, 0.2, 0.0), (0.2, 0.2, 0.2)] {
        assert!(single(&m, &[at(0.0, 0.0, 0.0), at(x, y, z)]).distance.abs() < BAR);
        let turn = Rotation3::new(Vector3::new(0.3, -0.2, 0.9)).into_inner();
        let turned = LinkPose { rotation: turn, origin: turn * Vector3::new(x, y, z) };
        let first = LinkPose { rotation: turn, origin: Vector3::zeros() };
        assert!(single(&m, &[first, turned]).distance.abs() < BAR, "{x} {y} {z}");
    }
    // One inside the other with equal centres: the way out is the whole width, in any direction.
    let found = single(&m, &[at(0.0, 0.0, 0.0); 2]);
    assert!((found.distance + 0.2).abs() < BAR && (found.normal.abs().max() - 1.0).abs() < BAR, "{found:?}");
    assert_eq!(Matrix3::<f64>::identity(), LinkPose::IDENTITY.rotation);
}
