//! Instants at which topologies end, and changes of the owner.

use super::*;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4};

/// Where `f` changes from positive to negative in [low, high].
pub fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    assert!(f(low) > 0.0 && f(high) < 0.0, "{} {}", f(low), f(high));
    for _ in 0..100 {
        let middle = (low + high) / 2.0;
        if f(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

fn table() -> ConvexBody {
    ConvexBody::cuboid(Vector3::new(0.5, 0.5, 0.5))
}

/// Error: RESOLUTION where a function starts at zero, otherwise roundoff.
#[test]
fn a_box_that_slides_over_a_border_has_events_at_its_corners() {
    let top = ConvexBody::cuboid(Vector3::new(0.1, 0.1, 0.1));
    let pair = |x: f64| Pair::new(&top, level(x, 0.05, 0.6), &table(), level(0.0, 0.0, 0.0));
    let inside = pair(0.3).topology(Owner::FaceOfB(5), 1e-9);
    assert!((root(|x| pair(x).validity(&inside), 0.3, 0.5) - 0.4).abs() < 1e-15);
    let across = pair(0.45).topology(Owner::FaceOfB(5), 1e-9);
    assert_eq!(across.corners.iter().filter(|c| matches!(c, Corner::Crossing { .. })).count(), 2);
    assert!((root(|x| pair(x).validity(&across), 0.45, 0.7) - 0.6).abs() < 1e-15);
    assert!((root(|x| pair(-x).validity(&across), -0.45, -0.3) + 0.4).abs() < 1e-15);
    // Corners exactly on the border do not fire at once.
    let border = pair(0.4).topology(Owner::FaceOfB(5), 1e-9);
    assert_eq!(border.corners, inside.corners);
    assert!(pair(0.4).validity(&border) > 0.0);
    assert!((root(|x| pair(x).validity(&border), 0.4, 0.5) - 0.4).abs() < 2e-9);
}

/// Boxes of the same size start with all functions at zero.
#[test]
fn equal_boxes_on_each_other_start_with_a_valid_patch() {
    let pair = |x: f64, y: f64| Pair::new(&table(), level(x, y, 1.0), &table(), level(0.0, 0.0, 0.0));
    let mut held = pair(0.0, 0.0).topology(Owner::FaceOfB(5), 1e-9);
    assert_eq!(held.corners.len(), 4);
    assert!(pair(0.0, 0.0).validity(&held) > 0.0);
    // Along a side the event comes at 1e-9, and the next patch lasts to the end.
    let first = root(|x| pair(x, 0.0).validity(&held), 0.0, 0.1);
    assert!(first > 0.0 && first < 2e-9, "{first}");
    held = pair(first + 1e-9, 0.0).topology(Owner::FaceOfB(5), 1e-9);
    let corners = (held.corners.len(), held.corners.iter().filter(|c| matches!(c, Corner::B(_))).count());
    assert_eq!(corners, (4, 2), "{held:?}");
    assert!((root(|x| pair(x, 0.0).validity(&held), 0.1, 1.1) - 1.0).abs() < 1e-8);
}

/// A box turns about an edge that lies on the ground, by the angle `t` of its bottom face.
fn tilted(t: f64) -> Placement {
    let rotation = turn(Vector3::y() * -t);
    let edge = Vector3::new(-0.5, 0.0, -0.5);
    Placement::at_rest(rotation, -(rotation * edge))
}

#[test]
fn a_box_that_tilts_flat_has_an_event_when_it_is_flat() {
    let ground = ConvexBody::half_space();
    let pair = |t: f64| Pair::new(&table(), tilted(t), &ground, level(0.0, 0.0, 0.0));
    // Beyond 45 degrees the side is the incident face; the vertices of the bottom count by height.
    let side = pair(1.0).topology(Owner::FaceOfB(0), 1e-9);
    assert!((root(|t| pair(-t).validity(&side), -1.0, 0.1)).abs() < 1e-14);
    // Below it is the incident face: its raised corners are watched by their gaps.
    let bottom = pair(0.5).topology(Owner::FaceOfB(0), 1e-9);
    assert_eq!(bottom.corners.len(), 4);
    let raised = |t: f64| pair(t).geometry(&bottom).points.iter().map(|p| p.gap).fold(0.0, f64::max);
    assert!((raised(0.5) - turn(Vector3::x() * 0.5)[(2, 1)]).abs() < 1e-15 && raised(0.0).abs() < 1e-15);
    assert!((root(|t| pair(t).validity(&bottom), 0.5, 1.7) - FRAC_PI_2).abs() < 1e-14);
    let flat = pair(0.0).topology(Owner::FaceOfB(0), 1e-9);
    assert!(pair(0.0).validity(&flat) > 0.0);
}

/// The clipped polygon of a vertex on a border is a point; inside, its edges cross the border.
#[test]
fn a_vertex_on_a_border_has_an_event_when_it_moves_inside() {
    let rotation = turn(Vector3::z() * -0.3) * turn(Vector3::x() * 0.2) * turn(Vector3::y() * -0.3);
    let lowest = rotation * Vector3::new(-0.5, -0.5, -0.5);
    let pair = |x: f64| {
        let position = Vector3::new(0.5 - x, 0.0, 0.5) - lowest;
        Pair::new(&table(), Placement::at_rest(rotation, position), &table(), level(0.0, 0.0, 0.0))
    };
    let top = table().faces.iter().position(|face| face.normal.z > 0.5).unwrap() as u16;
    let held = pair(0.0).topology(Owner::FaceOfB(top), 1e-9);
    assert_eq!(held.corners.len(), 1);
    assert!((root(|x| pair(x).validity(&held), 0.0, 1e-6) - RESOLUTION).abs() < 1e-14);
    assert!((root(|x| pair(-x).validity(&held), 0.0, 1e-6) - RESOLUTION).abs() < 1e-14);
    assert_eq!(pair(1e-8).topology(Owner::FaceOfB(top), 1e-9).corners.len(), 3);
}

#[test]
fn an_edge_that_rolls_on_an_edge_has_an_event_when_its_face_touches() {
    let below = at(turn(Vector3::x() * FRAC_PI_4), 0.0, 0.0, 0.0);
    let pair = |t: f64, y: f64| {
        // A's lowest edge is along y, at x = 0.
        let rotation = turn(Vector3::y() * t) * turn(Vector3::y() * FRAC_PI_4);
        let edge = turn(Vector3::y() * -FRAC_PI_4) * Vector3::z() * -FRAC_1_SQRT_2;
        let position = Vector3::new(0.0, y, FRAC_1_SQRT_2) - rotation * edge;
        Pair::new(&table(), Placement::at_rest(rotation, position), &table(), below)
    };
    let start = pair(0.0, 0.1);
    let found = start.separation();
    assert!(found.distance.abs() < 1e-15 && matches!(found.owner, Some(Owner::Edges(..))));
    let held = start.topology(found.owner.unwrap(), 1e-9);
    assert!((root(|t| pair(t, 0.1).validity(&held), 0.0, 1.0) - FRAC_PI_4).abs() < 1e-14);
    assert!((root(|t| pair(-t, 0.1).validity(&held), 0.0, 1.0) - FRAC_PI_4).abs() < 1e-14);
    // Sliding along A's edge to its end, at y = 0.5 from its middle.
    assert!((root(|y| pair(0.0, y).validity(&held), 0.1, 1.0) - 0.5).abs() < 1e-14);
    assert!((root(|y| pair(0.0, -y).validity(&held), -0.1, 1.0) - 0.5).abs() < 1e-14);
    // Beyond its end the edges do not touch.
    let beyond = pair(0.0, 0.6);
    assert!(!topology(&beyond.a, &beyond.pa, &beyond.b, &beyond.pb, 1e-9, held.owner, None, &mut Topology::new()));
}

#[test]
fn a_ball_leaves_faces_and_edges_at_their_borders() {
    let ball = ConvexBody::ball(0.2);
    let pair = |x: f64, y: f64, z: f64| Pair::new(&ball, level(x, y, z), &table(), level(0.0, 0.0, 0.0));
    let face = pair(0.3, 0.0, 0.7).topology(Owner::FaceOfB(5), 1e-9);
    assert!((root(|x| pair(x, 0.0, 0.7).validity(&face), 0.3, 0.6) - 0.5).abs() < 1e-15);
    // Over the edge, about (0.5, y, 0.5).
    let round = |t: f64, y: f64| {
        let arm = turn(Vector3::y() * t) * Vector3::z() * 0.2;
        pair(0.5 + arm.x, y, 0.5 + arm.z)
    };
    let owner = round(0.3, 0.0).separation().owner.unwrap();
    assert!(matches!(owner, Owner::VertexOfAEdgeOfB(..)), "{owner:?}");
    let edge = round(0.3, 0.0).topology(owner, 1e-9);
    assert!((root(|t| round(t, 0.0).validity(&edge), 0.3, 1.7) - FRAC_PI_2).abs() < 1e-14);
    assert!((root(|t| round(-t, 0.0).validity(&edge), -0.3, 0.1)).abs() < 1e-14);
    assert!((root(|y| round(0.3, y).validity(&edge), 0.0, 0.6) - 0.5).abs() < 1e-14);
    assert!((root(|y| round(0.3, -y).validity(&edge), 0.0, 0.6) - 0.5).abs() < 1e-14);
    // The next owner follows at once, without returning to the last one.
    for dx in [1e-12, 1e-9, 1e-6] {
        let owner = round(dx / 0.2, 0.0).separation().owner.unwrap();
        assert!(matches!(owner, Owner::VertexOfAEdgeOfB(..)), "{dx} {owner:?}");
        assert_eq!(pair(0.5 - dx, 0.0, 0.7).separation().owner, Some(Owner::FaceOfB(5)), "{dx}");
    }
}

/// While the validity of a held topology is positive, a new one has the same corners; when the
/// corners differ, it is not positive. Bodies slide and turn on each other on random ways, flat and
/// tilted.
#[test]
fn held_topologies_are_valid_as_long_as_new_ones_are_equal() {
    let mut random = Random::new(83);
    let ring = |count: usize, random: &mut Random| {
        let corner = |k: usize, r: f64| {
            turn(Vector3::z() * (std::f64::consts::TAU * k as f64 / count as f64)) * Vector3::x() * r
        };
        let r = 0.5 + 0.1 * random.next();
        ConvexBody::plate(&(0..count).map(|k| corner(k, r)).collect::<Vec<_>>()).unwrap()
    };
    let (mut changes, mut checks) = (0, 0);
    for k in 0..60 {
        let (a, b) = match k % 3 {
            0 => (random.cuboid(), random.cuboid()),
            1 => (ring(3 + k % 5, &mut random), ring(3 + k % 4, &mut random)),
            _ => (ConvexBody::capsule(0.4, 0.1), random.cuboid()),
        };
        let start = match k % 6 {
            2 | 5 => turn(Vector3::y() * FRAC_PI_2),
            3 => turn(Vector3::new(0.2, 0.1, 0.0)),
            _ => Matrix3::identity(),
        };
        let lowest = a.vertices.iter().map(|v| (start * v).z).fold(f64::INFINITY, f64::min);
        let bottom = b.vertices[b.vertices.len() - 1].z - lowest + a.rounding;
        let owner = Owner::FaceOfB(if k % 3 == 1 { 0 } else { 5 });
        let (shift, way, spin) = (random.vector() * 0.3, random.vector(), random.next());
        let pair = |t: f64| {
            let rotation = turn(Vector3::z() * (spin * t)) * start;
            let path = shift + way * t;
            Pair::new(&a, at(rotation, path.x, path.y, bottom), &b, level(0.0, 0.0, 0.0))
        };
        let mut held = pair(0.0).topology(owner, 10.0);
        for step in 1..400 {
            let now = pair(step as f64 * 1e-3);
            let mut new = Topology::new();
            if !topology(&now.a, &now.pa, &now.b, &now.pb, 10.0, owner, held.incident, &mut new) {
                break;
            }
            let equal = same_ring(&new.corners, &held.corners);
            let value = now.validity(&held);
            assert!((value > 0.0) == equal, "{k} {step}: {value} {:?} {:?}", new.corners, held.corners);
            checks += 1;
            if !equal {
                changes += 1;
                held = new;
            }
        }
    }
    assert!(changes > 50 && checks > 5000, "{changes} {checks}");
}

fn same_ring(a: &[Corner], b: &[Corner]) -> bool {
    a.len() == b.len()
        && (a.is_empty() || (0..a.len()).any(|shift| (0..a.len()).all(|k| a[k] == b[(k + shift) % a.len()])))
}

/// At a flat instant with the relative angular velocity along n. Error: roundoff.
#[test]
fn a_change_of_owner_alters_nothing_at_a_flat_instant() {
    let mut random = Random::new(89);
    let mut kinds = [0; 4];
    let square = [[-0.5, -0.4], [0.5, -0.4], [0.5, 0.4], [-0.5, 0.4]].map(|[x, y]| Vector3::new(x, y, 0.0));
    let plate = ConvexBody::plate(&square).unwrap();
    for k in 0..80 {
        // Cuboids, plates on cuboids, and plates on plates.
        let b = if k % 8 >= 6 { plate.clone() } else { ConvexBody::cuboid(Vector3::new(0.5, 0.4, 0.3)) };
        let a = if k % 8 >= 4 { plate.clone() } else { random.cuboid() };
        let half = |body: &ConvexBody| body.vertices.iter().map(|v| v.z).fold(0.0, f64::max);
        let height = half(&a) + half(&b);
        let pb = random.placement();
        let n: Vector3<f64> = pb.rotation.column(2).into();
        let pa = Placement {
            rotation: pb.rotation * turn(Vector3::z() * (3.0 * random.next())),
            position: pb.point(&Vector3::new(0.5 * random.next(), 0.4 * random.next(), height)),
            velocity: random.vector(),
            omega: pb.omega + n * random.next(),
        };
        let mut pair = Pair::new(&a, pa, &b, pb);
        let mut owner = Owner::FaceOfB(if k % 8 >= 6 { 0 } else { 5 });
        if k % 2 == 1 {
            pair = pair.swapped();
            owner = swap(owner);
        }
        let held = pair.topology(owner, 1e-9);
        let before = pair.geometry(&held);
        let count = held.corners.len();
        for first in 0..count {
            for pattern in [vec![first], vec![first, (first + 1) % count], vec![]] {
                let clamped: Vec<bool> = (0..count).map(|c| pattern.is_empty() || pattern.contains(&c)).collect();
                let new = reowner(&held, |c| clamped[c], &pair.a, &pair.pa, &pair.b, &pair.pb);
                let Some(new) = new else {
                    kinds[0] += 1;
                    continue;
                };
                kinds[match new {
                    Owner::Edges(..) => 1,
                    _ if pattern.len() == 1 => 2,
                    _ => 3,
                }] += 1;
                let mut next = held.clone();
                assert!(topology(&pair.a, &pair.pa, &pair.b, &pair.pb, 1e-9, new, None, &mut next), "{new:?}");
                let after = pair.geometry(&next);
                assert!((after.axes.column(2) - before.axes.column(2)).norm() < 1e-12, "{new:?}");
                assert!(pair.validity(&next) > 0.0);
                for c in pattern {
                    let corner = held.corners[c];
                    let at = next.corners.iter().position(|&other| other == corner).unwrap();
                    let (p, q) = (before.points[c], after.points[at]);
                    assert!((p.position - q.position).norm() < 1e-12 && (p.gap - q.gap).abs() < 1e-12);
                    assert!((p.velocity - q.velocity).norm() < 1e-12, "{new:?} {corner:?}");
                    assert!((p.bias - q.bias).norm() < 1e-9 * (1.0 + p.bias.norm()), "{new:?} {corner:?}");
                }
            }
        }
    }
    assert!(kinds.iter().all(|&kind| kind > 20), "{kinds:?}");
}

#[test]
fn the_border_that_stays_in_contact_decides_the_owner() {
    // A overhangs B at x = 0.5: its left vertices rest on B, its bottom edges cross the border.
    let pair = Pair::new(&table(), level(0.3, 0.1, 1.0), &table(), level(0.0, 0.2, 0.0));
    let held = pair.topology(Owner::FaceOfB(5), 1e-9);
    let is_right =
        |c: &Corner| pair.geometry(&held).points[held.corners.iter().position(|d| d == c).unwrap()].position.x > 0.4;
    let owner = |f: &dyn Fn(&Corner) -> bool| {
        let clamped: Vec<bool> = held.corners.iter().map(f).collect();
        reowner(&held, |c| clamped[c], &pair.a, &pair.pa, &pair.b, &pair.pb)
    };
    let is_crossing = |c: &Corner| matches!(c, Corner::Crossing { .. });
    assert_eq!(owner(&|c| is_right(c)), Some(Owner::FaceOfA(4)));
    assert_eq!(owner(&|c| !is_right(c) && matches!(c, Corner::A(_) | Corner::Crossing { .. })), None);
    assert_eq!(owner(&|c| matches!(c, Corner::A(_))), None);
    assert_eq!(owner(&|c| matches!(c, Corner::B(_))), Some(Owner::FaceOfA(4)));
    assert_eq!(owner(&|_| true), None);
    assert!(matches!(owner(&|c| is_crossing(c) && is_right(c)), Some(Owner::Edges(..))));
}

/// The crossing of a lying capsule with one side of the face reaches the next side.
#[test]
fn a_capsule_across_a_corner_has_an_event_at_the_corner() {
    let lying = turn(Vector3::z() * FRAC_PI_4) * turn(Vector3::y() * FRAC_PI_2);
    let capsule = ConvexBody::capsule(0.4, 0.1);
    let pair = |y: f64| Pair::new(&capsule, at(lying, 0.4, y, 0.6), &table(), level(0.0, 0.0, 0.0));
    let held = pair(0.0).topology(Owner::FaceOfB(5), 1e-9);
    assert_eq!(held.corners.len(), 2, "{held:?}");
    assert!((root(|y| pair(y).validity(&held), 0.0, 0.5) - 0.4).abs() < 1e-14);
    let next = pair(0.45).topology(Owner::FaceOfB(5), 1e-9);
    assert!(next.corners.len() == 2 && !same_ring(&next.corners, &held.corners));
    // It starts with the validity of a new patch.
    let corner = pair(0.4).topology(Owner::FaceOfB(5), 1e-9);
    assert!(pair(0.4).validity(&corner) > 0.0);
}
