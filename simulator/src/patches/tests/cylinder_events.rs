//! Instants at which topologies of cylinders end, and changes between rim and end.

use super::events::root;
use super::*;
use std::f64::consts::FRAC_PI_2;

fn pillar() -> ConvexBody {
    ConvexBody::cylinder(0.5, 0.2)
}

/// A cylinder on the ground that is tilted by `t` towards the direction `angle`, about its rim.
fn tilted(t: f64, angle: f64) -> Pair {
    let toward = turn(Vector3::z() * angle) * Vector3::x();
    let rotation = turn(Vector3::z().cross(&toward) * t);
    // The pivot is the rim point in the direction of the tilt, for positive t.
    let pivot = toward * 0.2 - Vector3::z() * 0.5;
    let position = toward * 0.2 - rotation * pivot;
    Pair::new(&pillar(), Placement::at_rest(rotation, position), &ConvexBody::half_space(), level(0.0, 0.0, 0.0))
}

const FLOOR: Owner = Owner::FaceOfB(0);

#[test]
fn a_rim_that_comes_down_has_an_event_when_it_is_flat() {
    for angle in [0.0, 0.7, 2.0, 4.0] {
        let rim = tilted(0.3, angle).topology(FLOOR, 1e-9);
        assert_eq!((rim.incident, rim.corners.len()), (None, 2));
        let landed = root(|t| tilted(-t, angle).validity(&rim), -0.3, 0.2);
        assert!((landed + 1e-6).abs() < 1e-12, "{landed}");
        // Nothing else stops it there, even in a step that goes beyond.
        assert!((1..100).all(|k| tilted(-1e-3 * k as f64, angle).validity(&rim) < 0.0));
        // The ring has the point of the rim.
        let end = tilted(0.0, angle);
        let mut flat = rim.clone();
        assert!(topology(&end.a, &end.pa, &end.b, &end.pb, 1e-9, FLOOR, None, &mut flat));
        assert_eq!((flat.incident, flat.corners.len()), (Some(0), RING));
        assert!(end.validity(&flat) > 0.0);
        let just = tilted(1e-6, angle);
        let mut flat = rim.clone();
        assert!(topology(&just.a, &just.pa, &just.b, &just.pb, 1e-9, FLOOR, None, &mut flat));
        assert_eq!(flat.incident, Some(0));
        let pivot = turn(Vector3::z() * angle) * Vector3::x() * 0.2;
        let nearest =
            just.geometry(&flat).points.iter().map(|p| (p.position - pivot).norm()).fold(f64::INFINITY, f64::min);
        // The rotation has an error of 1e-16/1e-6.
        assert!(nearest < 1e-9, "{nearest}");
    }
}

/// The end is left when the rim between the points of the ring is deeper by 1e-9 m, or the tilt exceeds 1e-3.
#[test]
fn an_end_that_tips_hands_over_to_its_rim() {
    let flat = tilted(0.0, 0.0).topology(FLOOR, 1e-9);
    assert_eq!(flat.incident, Some(0));
    let first = pillar().any_across();
    let of_ring = first.y.atan2(first.x);
    let step = std::f64::consts::TAU / RING as f64;
    // Over a point of the ring, and between two.
    let at_point = root(|t| tilted(t, of_ring).validity(&flat), 0.0, 0.1);
    assert!((at_point - 1e-3).abs() < 1e-8, "{at_point}");
    let between = root(|t| tilted(t, of_ring + step / 2.0).validity(&flat), 0.0, 0.1);
    let expected = 1e-9 / (0.2 * (1.0 - (step / 2.0).cos()));
    assert!((between - expected).abs() < 1e-3 * expected, "{between} {expected}");
    // Then the rim follows, even where the distance of near corners would allow the end.
    for (t, angle) in [(between * 1.001, of_ring + step / 2.0), (1.001e-3, of_ring)] {
        let now = tilted(t, angle);
        let mut next = flat.clone();
        assert!(topology(&now.a, &now.pa, &now.b, &now.pb, 1e-8, FLOOR, Some(0), &mut next));
        assert_eq!(next.incident, None, "{t}");
        let gaps: Vec<f64> = now.geometry(&next).points.iter().map(|p| p.gap).collect();
        assert!(gaps[0].abs() < 1e-15, "{gaps:?}");
    }
}

/// A coin that rolls on its rim keeps its topology while it is steep, and renews it every 60 degrees near upright.
#[test]
fn a_rolling_rim_keeps_its_topology() {
    let rolled = |tilt: f64, roll: f64| {
        let rotation = turn(Vector3::y() * tilt) * turn(Vector3::z() * roll);
        let lowest = 0.5 * tilt.cos() + 0.2 * tilt.sin();
        Pair::new(&pillar(), at(rotation, 0.0, 0.0, lowest), &ConvexBody::half_space(), level(0.0, 0.0, 0.0))
    };
    let steep = rolled(0.6, 0.0).topology(FLOOR, 1e-9);
    assert!((0..20).all(|k| rolled(0.6, k as f64).validity(&steep) > 0.0));
    let low = rolled(0.1, 0.0).topology(FLOOR, 1e-9);
    let third = std::f64::consts::FRAC_PI_3;
    assert!((root(|roll| rolled(0.1, roll).validity(&low), 0.0, 2.0) - third).abs() < 1e-14);
    let lying = rolled(FRAC_PI_2, 0.0).topology(FLOOR, 1e-9);
    assert_eq!(lying.corners.len(), 2);
    assert!((0..20).all(|k| rolled(FRAC_PI_2, k as f64).validity(&lying) > 0.0));
}

/// As for polyhedra: bodies slide and turn on faces on random ways.
#[test]
fn held_topologies_of_cylinders_are_valid_as_long_as_new_ones_are_equal() {
    let mut random = Random::new(107);
    let coin = ConvexBody::cylinder(0.1, 0.45);
    let (mut changes, mut checks) = (0, 0);
    for k in 0..60 {
        let a = match k % 5 {
            0 => pillar(),
            1 => coin.clone(),
            2 => random.cuboid(),
            3 => ConvexBody::capsule(0.4, 0.1),
            _ => pillar(),
        };
        let (b, face, top) = if k % 5 < 2 && k % 2 == 0 {
            (ConvexBody::cuboid(Vector3::new(0.5, 0.4, 0.3)), 5, 0.3)
        } else {
            (ConvexBody::cylinder(0.2, 0.5), 1, 0.2)
        };
        let start = if k % 5 < 3 { Matrix3::identity() } else { turn(Vector3::y() * FRAC_PI_2) };
        let bottom = top
            - Pair::new(&a, at(start, 0.0, 0.0, 0.0), &ConvexBody::half_space(), level(0.0, 0.0, 0.0))
                .separation()
                .distance;
        let (shift, way, spin) = (random.vector() * 0.3, random.vector(), random.next());
        let pair = |t: f64| {
            let rotation = turn(Vector3::z() * (spin * t)) * start;
            let path = shift + way * t;
            Pair::new(&a, at(rotation, path.x, path.y, bottom), &b, level(0.0, 0.0, 0.0))
        };
        let owner = Owner::FaceOfB(face);
        let mut held = pair(0.0).topology(owner, 1e-8);
        for step in 1..400 {
            let now = pair(step as f64 * 1e-3);
            let mut new = held.clone();
            if !topology(&now.a, &now.pa, &now.b, &now.pb, 1e-8, owner, held.incident, &mut new) {
                break;
            }
            let equal = new.corners.len() == held.corners.len() && new.corners.iter().all(|c| held.corners.contains(c));
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

/// At a flat instant the box's face takes over from the end of a cylinder without a change; crossings stay.
#[test]
fn a_change_of_owner_alters_nothing_at_a_flat_instant() {
    let cube = ConvexBody::cuboid(Vector3::new(0.5, 0.4, 0.3));
    let mut random = Random::new(109);
    let mut kinds = [0; 2];
    for k in 0..20 {
        let pb = random.placement();
        let n: Vector3<f64> = pb.rotation.column(2).into();
        let (a, z) = if k % 2 == 0 { (pillar(), 0.8) } else { (ConvexBody::cylinder(0.05, 0.45), 0.35) };
        let pa = Placement {
            rotation: pb.rotation * turn(Vector3::z() * random.next()),
            position: pb.point(&Vector3::new(0.5, 0.1 * random.next(), z)),
            velocity: random.vector(),
            omega: pb.omega + n * random.next(),
        };
        // The end of the cylinder owns the plane: it is B's.
        let pair = Pair::new(&cube, pb, &a, pa);
        let held = pair.topology(Owner::FaceOfB(0), 1e-9);
        let before = pair.geometry(&held);
        for c in 0..held.corners.len() {
            let clamped: Vec<bool> = (0..held.corners.len()).map(|i| i == c).collect();
            let new = reowner(&held, |c| clamped[c], &pair.a, &pair.pa, &pair.b, &pair.pb);
            let Some(new) = new else {
                kinds[0] += 1;
                continue;
            };
            assert!(matches!(new, Owner::FaceOfA(5)), "{new:?}");
            kinds[1] += 1;
            let mut next = held.clone();
            assert!(topology(&pair.a, &pair.pa, &pair.b, &pair.pb, 1e-9, new, None, &mut next), "{new:?}");
            let after = pair.geometry(&next);
            let p = before.points[c];
            let q = after.points.iter().find(|q| (p.position - q.position).norm() < 1e-9);
            let q = q.unwrap_or_else(|| panic!("{new:?} {p:?} {after:?}"));
            assert!((after.axes.column(2) - before.axes.column(2)).norm() < 1e-9, "{new:?}");
            assert!((p.velocity - q.velocity).norm() < 1e-9 && (p.bias - q.bias).norm() < 1e-7, "{new:?} {p:?} {q:?}");
            assert!(pair.validity(&next) > 0.0, "{new:?}");
        }
    }
    assert!(kinds.iter().all(|&kind| kind > 5), "{kinds:?}");
}

/// A ring turns towards a load on a side between two of its points, and not for loads elsewhere.
#[test]
fn a_ring_turns_towards_a_load_on_its_side() {
    let pair = tilted(0.0, 0.0);
    let flat = pair.topology(FLOOR, 1e-9);
    let step = std::f64::consts::TAU / RING as f64;
    let first = pillar().any_across();
    // The end of `tilted` is at the origin.
    let direction = |angle: f64| turn(Vector3::z() * angle) * first;
    let turned = |load: Vector3<f64>| turn_ring(&flat, &load, (&pair.a, &pair.pa), (&pair.b, &pair.pb));
    for share in [0.3, 0.5, 0.9] {
        let load = direction(0.0) * (0.2 * (1.0 - share)) + direction(step) * (0.2 * share);
        let next = turned(load).unwrap();
        let point = load.normalize() * 0.2;
        let corners = pair.geometry(&next).points;
        let nearest = corners.iter().map(|p| (p.position - point).norm()).fold(f64::INFINITY, f64::min);
        assert!(corners.len() == RING && nearest < 1e-12, "{nearest}");
        assert!(pair.validity(&next) > 0.0);
        // No turn is left.
        assert!(turn_ring(&next, &load, (&pair.a, &pair.pa), (&pair.b, &pair.pb)).is_none());
        assert!(!next.has_rings_of(&flat));
    }
    assert!(turned(direction(step) * 0.2).is_none());
    assert!(turned(direction(0.5 * step) * 0.15).is_none());
}

/// The next owner follows at once, without returning to the last one, where a rim leaves a face, and where a side
/// leaves it along its border.
#[test]
fn rims_and_sides_leave_faces_at_their_borders() {
    let cube = ConvexBody::cuboid(Vector3::new(0.5, 0.4, 0.3));
    let coin = ConvexBody::cylinder(0.05, 0.4);
    let on = |b: &ConvexBody, rotation: Matrix3<f64>, x: f64| {
        let mut pair = Pair::new(&coin, at(rotation, 0.0, 0.0, 1.0), b, level(0.0, 0.0, 0.0));
        let height = Pair { b: ConvexBody::half_space(), ..pair.clone() }.separation().distance;
        // The lowest point, at x = 0 of the cylinder's frame, gets to x and the upper face.
        let down = rotation.tr_mul(&Vector3::z());
        let low = pair.a.across(&down).try_normalize(0.0).unwrap() * -0.4 - pair.a.axis() * (0.05 * down.z.signum());
        pair.pa.position = Vector3::new(x, 0.1, 1.0 - height + b.faces[b.faces.len() - 1].offset) - {
            let low = rotation * low;
            Vector3::new(low.x, low.y, 0.0)
        };
        pair
    };
    let other = ConvexBody::cylinder(0.3, 0.5);
    let border = (0.25f64 - 0.01).sqrt();
    for (rotation, name) in [(turn(Vector3::new(0.2, 0.6, 0.0)), "rim"), (turn(Vector3::x() * FRAC_PI_2), "side")] {
        for (body, x, face) in [(&cube, 0.5, 5), (&other, border, 1)] {
            if name == "side" && face == 1 {
                continue;
            }
            for dx in [1e-11, 1e-9, 1e-6] {
                let inside = on(body, rotation, x - dx).separation();
                assert_eq!(inside.owner, Some(Owner::FaceOfB(face)), "{name} {dx}");
                let beyond = on(body, rotation, x + dx).separation();
                let is_next = matches!(beyond.owner, Some(Owner::Curved(..) | Owner::Along(..)));
                assert!(is_next && beyond.distance.abs() < 1e-9, "{name} {dx} {beyond:?}");
            }
        }
    }
}

/// A roof with its ridge along x at height 0 and y = `y`, 1.2 m long, under the end of a cylinder with radius 0.2.
fn on_ridge(y: f64, end: Placement) -> Pair {
    let roof = ConvexBody::cuboid(Vector3::new(0.6, 0.5, 0.5));
    let slope = turn(Vector3::x() * -0.05);
    let ridge = slope * Vector3::new(0.0, -0.5, 0.5);
    let below = Placement::at_rest(slope, Vector3::new(0.0, y, 0.0) - ridge);
    Pair::new(&pillar(), end, &roof, below)
}

const END: Owner = Owner::FaceOfA(0);

/// A point of a ring on a border has the place of the rim's crossing, which appears when the point moves inside.
#[test]
fn a_point_of_a_ring_on_a_border_has_an_event_when_it_moves_inside() {
    let upright = level(0.0, 0.0, 0.5);
    let first = pillar().any_across();
    let point = turn(Vector3::z() * std::f64::consts::TAU * -2.0 / RING as f64) * first * 0.2;
    let pair = |inside: f64| on_ridge(point.y - inside, upright);
    let held = pair(0.0).topology(END, 1e-9);
    let crossings = |held: &Topology| held.corners.iter().filter(|c| matches!(c, Corner::Crossing { .. })).count();
    assert!(crossings(&held) < 2, "{:?}", held.corners);
    assert!((root(|y| pair(y).validity(&held), 0.0, 1e-6) - RESOLUTION).abs() < 1e-14);
    assert!((root(|y| pair(-y).validity(&held), 0.0, 1e-6) - RESOLUTION).abs() < 1e-14);
    assert_eq!(crossings(&pair(1e-7).topology(END, 1e-9)), 2);
    // No load at a crossing turns a point of the ring to it.
    let next = pair(1e-7);
    let held = next.topology(END, 1e-9);
    let corners = next.geometry(&held).points;
    let at = |corner: &Corner| matches!(corner, Corner::Crossing { .. });
    for c in (0..corners.len()).filter(|&c| at(&held.corners[c])) {
        assert!(turn_ring(&held, &corners[c].position, (&next.a, &next.pa), (&next.b, &next.pb)).is_none());
    }
}

/// An end that turns about a crossing of its rim and the ridge is left when the end of the ridge is 1e-6 m above its
/// plane; the rim and the ridge then own the plane, with the same normal.
#[test]
fn an_end_that_turns_about_a_crossing_hands_over_to_its_rim() {
    let y = 0.05;
    let x = (0.2f64 * 0.2 - y * y).sqrt();
    let pair = |t: f64| {
        let rotation = turn(Vector3::y() * t);
        let pivot = Vector3::new(x, y, -0.5);
        on_ridge(y, Placement::at_rest(rotation, Vector3::new(x, y, 0.0) - rotation * pivot))
    };
    let held = pair(0.0).topology(END, 1e-9);
    let dipped = root(|t| pair(t).validity(&held), 0.0, 0.1);
    assert!((dipped.sin() - 1e-6 / (0.6 - x)).abs() < 1e-12, "{dipped}");
    let next = pair(dipped);
    let found = next.separation();
    assert!(found.distance.abs() < 1e-12 && matches!(found.owner, Some(Owner::Curved(..))), "{found:?}");
    let rim = next.geometry(&next.topology(found.owner.unwrap(), 1e-9));
    let end = next.geometry(&held);
    assert!((rim.axes.column(2) - end.axes.column(2)).norm() < 1e-5);
}

/// Where a steep side leaves a border, its crossing and its end are two corners after a few events, not after one for
/// each nanometre of its length.
#[test]
fn a_steep_side_leaves_a_border_with_few_events() {
    let cube = ConvexBody::cuboid(Vector3::new(0.5, 0.5, 0.5));
    let rotation = turn(Vector3::y() * 0.02);
    let low = rotation * Vector3::new(0.2, 0.0, -0.5);
    let high = rotation * Vector3::new(0.2, 0.0, 0.5);
    // The upper end of the side is above the border at x = 0.
    let pair = |x: f64| {
        let position = Vector3::new(0.5 + x - high.x, 0.0, 0.5 - low.z);
        Pair::new(&pillar(), Placement::at_rest(rotation, position), &cube, level(0.0, 0.0, 0.0))
    };
    let face = cube.faces.iter().position(|face| face.normal.z > 0.5).unwrap() as u16;
    let (mut x, mut events) = (-1e-3, 0);
    let mut held = pair(x).topology(Owner::FaceOfB(face), 1e-9);
    while !held.corners.iter().any(|corner| matches!(corner, Corner::Crossing { .. })) {
        x = root(|x| pair(x).validity(&held), x, x + 1e-2) + 1e-14;
        held = pair(x).topology(Owner::FaceOfB(face), 1e-9);
        events += 1;
        assert!(events < 4, "{x} {:?}", held.corners);
    }
    assert!((1..4).contains(&events) && x.abs() < 1e-8, "{x}");
}
