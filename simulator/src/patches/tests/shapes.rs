//! Closed forms: patches of boxes, normals and distances, shapes of bodies. Errors: roundoff.

use super::*;
use crate::patches::body::NO_FACE;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

fn unit() -> ConvexBody {
    ConvexBody::cuboid(Vector3::new(0.5, 0.5, 0.5))
}

/// Checks that the corners lie on a convex polygon with this area, counter-clockwise about n.
fn check_polygon(pair: &Pair, topology: &Topology, area: f64) {
    let at = pair.geometry(topology);
    let flat: Vec<Vector3<f64>> = at.points.iter().map(|p| at.axes.tr_mul(&p.position)).collect();
    let count = flat.len();
    let sum: f64 = (0..count).map(|k| flat[k].xy().perp(&flat[(k + 1) % count].xy())).sum();
    assert!((sum / 2.0 - area).abs() < 1e-12, "{} {area}", sum / 2.0);
    for k in 0..count {
        let (p, q, r) = (flat[k].xy(), flat[(k + 1) % count].xy(), flat[(k + 2) % count].xy());
        assert!((q - p).perp(&(r - q)) > 0.0);
    }
    assert!(at.points.iter().all(|p| p.gap.abs() < 1e-12));
    assert!(pair.validity(topology) > 0.0);
}

fn count(topology: &Topology) -> [usize; 3] {
    let mut count = [0; 3];
    for corner in &topology.corners {
        count[match corner {
            Corner::A(_) => 0,
            Corner::B(_) => 1,
            Corner::Crossing { .. } => 2,
        }] += 1;
    }
    count
}

fn distance_and_owner(pair: &Pair) -> (f64, Option<Owner>) {
    let separation = pair.separation();
    (separation.distance, separation.owner)
}

#[test]
fn points_that_are_equal_up_to_rounding_are_one_corner() {
    let body = unit();
    for shift in [0.0, 1e-17, -3e-17, 1e-12] {
        let again = body.vertices.iter().map(|v| v + Vector3::new(shift, -shift, shift));
        let points: Vec<_> = body.vertices.iter().copied().chain(again).collect();
        let hull = ConvexBody::from_points(&points).unwrap();
        assert_eq!((hull.vertices.len(), hull.edges.len(), hull.faces.len()), (8, 12, 6), "{shift:e}");
        assert!(hull.faces.iter().all(|face| face.corners.len() == 4));
    }
}

/// Closed surfaces of triangles around all points: V - E + F = 2 with 2 E = 3 F, and no point above a face.
#[test]
fn hulls_of_many_points_close_around_them() {
    // Numbers between -1 and 1 of a linear congruential generator.
    let mut state = 11u64;
    let mut number = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let ball: Vec<Vector3<f64>> = (0..800).map(|_| Vector3::new(number(), number(), number()).normalize()).collect();
    let hull = ConvexBody::from_points(&ball).unwrap();
    assert_eq!((hull.vertices.len(), hull.faces.len(), hull.edges.len()), (800, 2 * 800 - 4, 3 * 800 - 6));
    // Grids on the sides of a cube, as a mesh in single precision has them, are coplanar up to 6e-8.
    let grid = |k: i32, noise: f64| f64::from(k) / 6.0 + 6e-8 * noise;
    let mut sides = Vec::new();
    for (i, j) in (-6..=6).flat_map(|i| (-6..=6).map(move |j| (i, j))) {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, -6), (axis, 6)]) {
            let mut p = Vector3::zeros();
            p[axis] = grid(side, number());
            p[(axis + 1) % 3] = grid(i, number());
            p[(axis + 2) % 3] = grid(j, number());
            sides.push(p);
        }
    }
    for (points, depth) in [(&ball, 1e-12), (&sides, 1e-6)] {
        let hull = ConvexBody::from_points(points).unwrap();
        for face in &hull.faces {
            let highest = points.iter().map(|p| face.normal.dot(p) - face.offset).fold(f64::MIN, f64::max);
            assert!(highest < depth, "{highest:e}");
        }
        assert!(hull.edges.iter().all(|edge| !edge.faces.contains(&NO_FACE)));
    }
}

#[test]
fn bodies_have_the_features_of_their_shapes() {
    let points: Vec<_> = unit().vertices.iter().map(|v| turn(Vector3::new(0.3, 0.7, 0.1)) * v).collect();
    for body in [unit(), ConvexBody::from_points(&points).unwrap()] {
        assert_eq!((body.vertices.len(), body.edges.len(), body.faces.len()), (8, 12, 6));
        for (k, face) in body.faces.iter().enumerate() {
            assert!((face.offset - 0.5).abs() < 1e-15);
            assert!(body.vertices.iter().all(|v| face.normal.dot(v) <= face.offset + 1e-15));
            for side in 0..4 {
                let inward = body.side_inward(k as u16, side);
                let edge = body.edge(face.edges[side]);
                assert!(edge.ends.contains(&face.corners[side]) && edge.ends.contains(&face.corners[(side + 1) % 4]));
                assert!((inward.norm() - 1.0).abs() < 1e-15 && inward.dot(&face.normal).abs() < 1e-15);
                assert!(
                    face.corners
                        .iter()
                        .all(|&c| inward.dot(&(body.vertex(c) - body.vertex(face.corners[side]))) > -1e-15)
                );
            }
        }
    }
    let hull = Random::new(3).hull(60);
    assert_eq!(hull.vertices.len() + hull.faces.len(), hull.edges.len() + 2);
    let plate = ConvexBody::plate(&[Vector3::zeros(), Vector3::x(), Vector3::y()]).unwrap();
    assert_eq!((plate.faces.len(), plate.edges.len()), (2, 3));
    assert_eq!(plate.edges[0].inward[0], plate.edges[0].inward[1]);
    assert!(ConvexBody::from_points(&[Vector3::zeros(), Vector3::x(), Vector3::y()]).is_none());
}

#[test]
fn flat_boxes_have_the_polygon_of_their_intersection() {
    // Position and angle of A; area; corners of A, of B, crossings.
    let octagon = 2.0 * (2.0f64.sqrt() - 1.0);
    let cases = [
        (0.0, 0.0, 0.0, 1.0, [4, 0, 0]),
        (0.25, 0.0, 0.0, 0.75, [2, 2, 0]),
        (0.25, 0.5, 0.0, 0.375, [1, 1, 2]),
        (0.0, 0.0, FRAC_PI_4, octagon, [0, 0, 8]),
        (0.75, 0.75, FRAC_PI_4, corner_cut(), [0, 1, 2]),
    ];
    for (x, y, angle, area, corners) in cases {
        let pair = Pair::new(&unit(), at(turn(Vector3::z() * angle), x, y, 1.0), &unit(), level(0.0, 0.0, 0.0));
        assert!(pair.separation().distance.abs() < 1e-15);
        assert_eq!(pair.separation().owner, Some(Owner::FaceOfB(5)));
        let topology = pair.topology(Owner::FaceOfB(5), 1e-9);
        check_polygon(&pair, &topology, area);
        assert_eq!(count(&topology), corners, "{x} {y} {angle}");
        // From below; both bodies are the same, so their owners have the mirror image.
        let topology = pair.topology(Owner::FaceOfA(4), 1e-9);
        check_polygon(&pair, &topology, area);
        let mirror = pair.swapped();
        check_polygon(&mirror, &mirror.topology(Owner::FaceOfA(5), 1e-9), area);
    }
}

/// A side of A at 45 degrees at the distance 0.5 from (0.75, 0.75) cuts the corner (0.5, 0.5) of B:
/// a triangle with the height 0.5 - 0.25 sqrt 2 and twice this as base.
fn corner_cut() -> f64 {
    let height = 0.5 - 0.25 * 2.0f64.sqrt();
    height * height
}

#[test]
fn a_small_box_inside_and_a_large_one_above_have_the_small_face() {
    let (small, large) = (ConvexBody::cuboid(Vector3::new(0.1, 0.2, 0.3)), unit());
    let pair = Pair::new(&small, level(0.1, 0.1, 0.8), &large, level(0.0, 0.0, 0.0));
    let topology = pair.topology(Owner::FaceOfB(5), 1e-9);
    check_polygon(&pair, &topology, 0.08);
    assert_eq!(count(&topology), [4, 0, 0]);
    let pair = Pair::new(&large, level(0.0, 0.0, 0.8), &small, level(0.1, 0.1, 0.0));
    let topology = pair.topology(Owner::FaceOfB(5), 1e-9);
    check_polygon(&pair, &topology, 0.08);
    assert_eq!(count(&topology), [0, 4, 0]);
}

#[test]
fn plates_and_half_spaces_have_patches() {
    let square = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| Vector3::new(x, y, 0.0));
    let plate = ConvexBody::plate(&square).unwrap();
    let ground = ConvexBody::half_space();
    let pair = Pair::new(&plate, level(3.0, 4.0, 0.0), &ground, level(0.0, 0.0, 0.0));
    assert_eq!(distance_and_owner(&pair), (0.0, Some(Owner::FaceOfB(0))));
    check_polygon(&pair, &pair.topology(Owner::FaceOfB(0), 1e-9), 1.0);
    let mirror = pair.swapped();
    assert_eq!(distance_and_owner(&mirror), (0.0, Some(Owner::FaceOfA(0))));
    check_polygon(&mirror, &mirror.topology(Owner::FaceOfA(0), 1e-9), 1.0);
    for height in [0.5, -0.5] {
        // On top of and below a box, overhanging.
        let pair = Pair::new(&plate, level(0.25, 0.0, height), &unit(), level(0.0, 0.0, 0.0));
        let (distance, owner) = distance_and_owner(&pair);
        assert!(distance.abs() < 1e-15);
        check_polygon(&pair, &pair.topology(owner.unwrap(), 1e-9), 0.75);
    }
    // A plate that stands on its edge, across the border: the lower edge is the patch, the upper
    // one has corners above.
    let upright = at(turn(Vector3::x() * (2.0 * FRAC_PI_4)), 0.25, 0.0, 1.0);
    let pair = Pair::new(&plate, upright, &unit(), level(0.0, 0.0, 0.0));
    let topology = pair.topology(Owner::FaceOfB(5), 1e-9);
    let points = pair.geometry(&topology).points;
    assert_eq!(points.iter().filter(|p| p.gap.abs() < 1e-12).count(), 2, "{topology:?}");
    assert_eq!(points.iter().filter(|p| (p.gap - 1.0).abs() < 1e-12).count(), 2);
    assert!(pair.validity(&topology) > 0.0);
}

#[test]
fn known_distances_and_normals() {
    let ground = ConvexBody::half_space();
    let cases = [
        // A face, an edge and a vertex of a unit cube 0.1 above the ground.
        (Vector3::zeros(), 0.5, 4),
        (Vector3::x() * FRAC_PI_4, FRAC_1_SQRT_2, 2),
        (diagonal(), 0.75f64.sqrt(), 1),
    ];
    for (angles, height, corners) in cases {
        let pair = Pair::new(&unit(), at(turn(angles), 0.3, 0.2, height + 0.1), &ground, level(0.0, 0.0, 0.0));
        assert!((pair.separation().distance - 0.1).abs() < 1e-15);
        let points = pair.geometry(&pair.topology(Owner::FaceOfB(0), 0.1 + 1e-9)).points;
        assert_eq!(points.iter().filter(|p| (p.gap - 0.1).abs() < 1e-12).count(), corners);
    }
    // Edges that cross at right angles, 0.1 apart.
    let below = at(turn(Vector3::x() * FRAC_PI_4), 0.0, 0.0, 0.0);
    let above = at(turn(Vector3::y() * FRAC_PI_4), 0.1, 0.2, 2.0 * FRAC_1_SQRT_2 + 0.1);
    let pair = Pair::new(&unit(), above, &unit(), below);
    let found = pair.separation();
    assert!((found.distance - 0.1).abs() < 1e-15);
    assert!(matches!(found.owner, Some(Owner::Edges(..))));
    let at = pair.geometry(&pair.topology(found.owner.unwrap(), 0.2));
    assert!((at.axes.column(2) - Vector3::z()).norm() < 1e-15);
    assert!((at.points[0].position - Vector3::new(0.1, 0.0, FRAC_1_SQRT_2 + 0.1)).norm() < 1e-15);
    // Balls and capsules.
    let (ball, rod) = (ConvexBody::ball(0.2), ConvexBody::capsule(0.5, 0.1));
    let gap = |a: &ConvexBody, x: f64, y: f64, z: f64, b: &ConvexBody| {
        Pair::new(a, level(x, y, z), b, level(0.0, 0.0, 0.0)).separation().distance
    };
    assert!((gap(&ball, 0.3, 0.0, 0.4, &ball) - 0.1).abs() < 1e-15);
    assert!((gap(&ball, 0.8, 0.9, 0.0, &unit()) - 0.3).abs() < 1e-15);
    assert!((gap(&ball, 0.8, 0.9, 1.7, &unit()) - 1.1).abs() < 1e-15);
    assert!((gap(&rod, 0.3, 0.4, 0.2, &rod) - 0.3).abs() < 1e-15);
    assert!((gap(&ball, 0.0, 0.0, 0.3, &unit()) + 0.4).abs() < 1e-15);
}

/// Turns a cube so that a vertex points down.
fn diagonal() -> Vector3<f64> {
    let from = Vector3::new(1.0, 1.0, 1.0).normalize();
    nalgebra::Rotation3::rotation_between(&from, &-Vector3::z()).unwrap().scaled_axis()
}

#[test]
fn owners_that_may_not_touch_are_left_out() {
    let mut table = unit();
    let pair = Pair::new(&unit(), level(0.0, 0.0, 1.0), &table, level(0.0, 0.0, 0.0));
    assert_eq!(pair.separation().owner, Some(Owner::FaceOfB(5)));
    table.set_touchable(5, false);
    let pair = Pair { b: table.clone(), ..pair };
    assert_eq!(distance_and_owner(&pair), (0.0, Some(Owner::FaceOfA(4))));
    let mut top = unit();
    top.set_touchable(4, false);
    let pair = Pair { a: top, ..pair };
    assert_eq!(distance_and_owner(&pair), (0.0, None));
    // A hint that separates ends the search.
    let pair = Pair { pa: level(0.2, 0.1, 1.3), a: unit(), ..pair };
    let found = separation(&pair.a, &pair.pa, &pair.b, &pair.pb, Some(Owner::FaceOfA(4)), 0.1);
    assert!((found.distance - 0.3).abs() < 1e-15 && found.owner == Some(Owner::FaceOfA(4)));
}

/// A vertex of A on the border of B, with the border going on inside of A.
#[test]
fn the_border_of_the_owner_continues_from_a_vertex_on_it() {
    let corners = [[0.5, -0.2], [2.0, 0.5], [-0.2, 2.0]].map(|[x, y]| Vector3::new(x, y, 0.0));
    let plate = ConvexBody::plate(&corners).unwrap();
    let pair = Pair::new(&plate, level(0.0, 0.0, 0.5), &unit(), level(0.0, 0.0, 0.0));
    let topology = pair.topology(Owner::FaceOfB(5), 1e-9);
    assert_eq!(count(&topology), [1, 1, 1], "{topology:?}");
    // The side from (-0.2, 2) to (0.5, -0.2) is at y = 0.5 at 0.7 * 0.7/2.2 from x = 0.5.
    check_polygon(&pair, &topology, 0.7 * (0.7 * 0.7 / 2.2) / 2.0);
}

/// The face at the end of a sharp ridge is the most opposed one, but lacks the lowest vertex.
#[test]
fn the_incident_face_has_the_lowest_vertex() {
    // A ridge bent at its middle vertex, and one with a level edge, which has two.
    check_ridge([[0.0, 0.0, 0.0], [1.0, 0.0, 0.05], [1.0, 0.1, 1.0], [2.0, 0.05, 0.55], [2.0, 0.05, 1.0]], 1);
    check_ridge([[0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.1, 1.0], [2.0, 0.05, 0.75], [2.0, 0.05, 1.0]], 2);
}

fn check_ridge(half: [[f64; 3]; 5], closed: usize) {
    let images = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let mut points: Vec<Vector3<f64>> = Vec::new();
    for (p, [x, y]) in half.iter().flat_map(|p| images.map(|image| (p, image))) {
        let point = Vector3::new(p[0] * x, p[1] * y, p[2]);
        if !points.contains(&point) {
            points.push(point);
        }
    }
    let ridge = ConvexBody::from_points(&points).unwrap();
    let pair = Pair::new(&ridge, level(0.0, 0.0, 0.0), &ConvexBody::half_space(), level(0.0, 0.0, 0.0));
    assert!(pair.separation().distance.abs() < 1e-15);
    let topology = pair.topology(Owner::FaceOfB(0), 1e-9);
    assert_eq!(pair.geometry(&topology).points.iter().filter(|p| p.gap.abs() < 1e-15).count(), closed);
    assert!(pair.validity(&topology) > 0.0);
}
