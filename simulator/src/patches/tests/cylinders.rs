//! Cylinders and parallel edges: separations against samples of directions, rates against finite
//! differences (errors: as in `rates`), corners against closed forms.

use super::rates::{advance, check, check_touching, moving, rate, second};
use super::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Greatest n . x over the points x of a body, from its shape alone; world.
fn support(body: &ConvexBody, at: &Placement, n: &Vector3<f64>) -> f64 {
    let d = at.rotation.tr_mul(n);
    let local = match body.barrel {
        // All tests have cylinders along z.
        Some(radius) => body.vertices[1].z * d.z.abs() + radius * d.xy().norm(),
        None => body.vertices.iter().map(|x| d.dot(x)).fold(f64::NEG_INFINITY, f64::max) + body.rounding,
    };
    local + n.dot(&at.position)
}

/// Greatest s(n) by samples of the sphere, refined from the best ones with ever smaller steps.
fn by_sampling(pair: &Pair, random: &mut Random) -> f64 {
    let s = |n: &Vector3<f64>| -support(&pair.a, &pair.pa, &-n) - support(&pair.b, &pair.pb, n);
    let mut starts: Vec<Vector3<f64>> = (0..3000).map(|_| random.direction()).collect();
    starts.sort_by(|n, m| s(m).total_cmp(&s(n)));
    let refine = |start: &Vector3<f64>, random: &mut Random| {
        let (mut n, mut best, mut size) = (*start, s(start), 0.1);
        while size > 1e-8 {
            let better = (0..60).map(|_| (n + random.direction() * size).normalize()).find(|m| s(m) > best);
            match better {
                Some(m) => (n, best) = (m, s(&m)),
                None => size *= 0.9,
            }
        }
        best
    };
    starts.iter().take(4).map(|n| refine(n, random)).fold(f64::NEG_INFINITY, f64::max)
}

/// Name of the kind of an owner.
fn kind(owner: Owner) -> String {
    match owner {
        Owner::Curved(i, j) => format!("{:?}", (matches!(i, Feature::Rim(_)), matches!(j, Feature::Rim(_)))),
        owner => format!("{owner:?}").split('(').next().unwrap().to_owned(),
    }
}

fn rod() -> ConvexBody {
    ConvexBody::cylinder(0.5, 0.2)
}

fn coin() -> ConvexBody {
    ConvexBody::cylinder(0.05, 0.4)
}

fn cube() -> ConvexBody {
    ConvexBody::cuboid(Vector3::new(0.5, 0.4, 0.3))
}

/// Bodies of all kinds against cylinders. Of bodies that overlap, and of rounded bodies, the separation is the
/// greatest s(n); of others that are apart it is a lower bound with the same sign. Error: that of the samples.
#[test]
fn cylinders_have_the_greatest_support_distance() {
    let mut random = Random::new(101);
    let others = [cube(), ConvexBody::ball(0.3), ConvexBody::capsule(0.5, 0.15), coin(), rod(), random.hull(12)];
    let mut kinds = std::collections::BTreeMap::new();
    for k in 0..240 {
        let (a, b) = (if k % 2 == 0 { rod() } else { coin() }, &others[k / 2 % 6]);
        let mut pair = Pair::new(&a, random.placement(), b, random.placement());
        pair.pa.position = pair.pb.position + random.direction() * (a.radius + b.radius) * (0.7 + 0.25 * random.next());
        let sampled = by_sampling(&pair, &mut random);
        if sampled < -0.03 {
            continue;
        }
        let found = pair.separation();
        assert!(found.distance < sampled + 1e-6, "{k}: {found:?} {sampled}");
        assert!(sampled.abs() < 1e-6 || (found.distance > 0.0) == (sampled > 0.0), "{k}: {found:?} {sampled}");
        if sampled < 0.0 || b.rounding > 0.0 {
            assert!((found.distance - sampled).abs() < 1e-6, "{k}: {found:?} {sampled}");
        }
        let mirror = pair.swapped().separation();
        assert!((mirror.distance - found.distance).abs() < 1e-13, "{k}: {found:?} {mirror:?}");
        *kinds.entry(kind(found.owner.unwrap())).or_insert(0) += 1;
    }
    assert!(kinds.len() >= 7 && kinds.values().all(|&count| count > 3), "{kinds:?}");
}

/// Pairs brought to contact have a patch with a closed gap and a positive validity.
#[test]
fn random_cylinders_in_contact_have_valid_patches() {
    let mut random = Random::new(103);
    let (mut kinds, mut checked) = (std::collections::BTreeMap::new(), 0);
    let others = [cube(), ConvexBody::ball(0.3), ConvexBody::capsule(0.5, 0.15), coin(), rod(), random.hull(12)];
    for k in 0..600 {
        let (a, b) = (if k % 2 == 0 { rod() } else { coin() }, &others[k / 2 % 6]);
        let mut pair = Pair::new(&a, random.placement(), b, random.placement());
        pair.pa.position = pair.pb.position + random.direction() * 4.0;
        let way = (pair.pb.position - pair.pa.position).normalize();
        for _ in 0..4000 {
            let distance = pair.separation().distance;
            if distance < 1e-13 {
                break;
            }
            pair.pa.position += way * distance;
        }
        let found = pair.separation();
        assert!(found.distance.abs() < 1e-12, "{k}: {found:?}");
        let owner = found.owner.unwrap();
        let topology = pair.topology(owner, 1e-9);
        let at = pair.geometry(&topology);
        let gap = at.points.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
        assert!(gap.abs() < 1e-9, "{k}: {topology:?} {gap}");
        assert!(pair.validity(&topology) > 0.0, "{k}: {topology:?} {}", pair.validity(&topology));
        // The point lies on both bodies.
        let point = at.points.iter().find(|p| p.gap == gap).unwrap();
        for (body, placement, n) in
            [(&pair.a, &pair.pa, -at.axes.column(2)), (&pair.b, &pair.pb, at.axes.column(2).into())]
        {
            let n: Vector3<f64> = n;
            assert!((support(body, placement, &n) - n.dot(&point.position)).abs() < 1e-9, "{k}: {topology:?}");
        }
        *kinds.entry(kind(owner)).or_insert(0) += 1;
        // Differences need a normal that does not turn fast.
        let turns =
            rate(|t| advance(&pair, &[Vector3::zeros(); 2], t).geometry(&topology).axes.column(2).into()).norm();
        if turns > 4.0 {
            continue;
        }
        checked += 1;
        check(&pair, &topology, 1e-9, "random");
    }
    assert!(kinds.len() >= 7 && checked > 400, "{kinds:?} {checked}");
}

#[test]
fn rims_and_sides_have_exact_rates() {
    let (rod, coin, ground) = (rod(), coin(), ConvexBody::half_space());
    let (ball, capsule) = (ConvexBody::ball(0.3), ConvexBody::capsule(0.5, 0.1));
    let still = moving(11, turn(Vector3::new(0.1, -0.2, 0.3)), 0.0, 0.0, 0.0);
    let tilted =
        |seed: u64, v: [f64; 3], x: f64, y: f64, z: f64| moving(seed, still.rotation * turn(v.into()), x, y, z);
    // On planes and faces, by the rim and by the side.
    check_touching(
        Pair::new(&coin, tilted(31, [0.9, 0.2, 0.4], 0.1, 0.2, 1.0), &ground, still),
        Owner::FaceOfB(0),
        "rim",
    );
    check_touching(
        Pair::new(&rod, tilted(32, [FRAC_PI_2, 0.0, 0.0], 0.1, 0.2, 1.0), &ground, still),
        Owner::FaceOfB(0),
        "side",
    );
    let base = moving(33, Matrix3::identity(), 0.0, 0.0, 0.0);
    let on = |seed: u64, v: [f64; 3], x: f64, y: f64, z: f64| moving(seed, turn(v.into()), x, y, z);
    check_touching(
        Pair::new(&rod, on(34, [0.7, 0.2, 0.4], 0.1, 0.2, 1.0), &cube(), base),
        Owner::FaceOfB(5),
        "rim, face",
    );
    let edge = |ends: [u16; 2]| {
        let is = |e: &Edge| e.ends == ends || e.ends == [ends[1], ends[0]];
        cube().edges.iter().position(is).unwrap() as u16
    };
    // The upper edge at x = 0.5 runs between the vertices 5 and 7.
    let (upper, rim, side) = (edge([5, 7]), Feature::Rim, Feature::Edge(0));
    let cases: [(&ConvexBody, Placement, &ConvexBody, Owner, &str); 9] = [
        (&rod, on(35, [0.0, 2.2, 0.0], 0.55, 0.1, 1.0), &cube(), Owner::Edges(0, upper), "side, edge"),
        (
            &rod,
            on(36, [0.2, 0.1, 0.0], 0.65, 0.1, 0.9),
            &cube(),
            Owner::Curved(rim(0), Feature::Edge(upper)),
            "rim, edge",
        ),
        (&rod, on(37, [0.5, -0.5, 0.0], 0.7, 0.6, 0.9), &cube(), Owner::EdgeOfAVertexOfB(0, 7), "side, vertex"),
        (&ball, on(38, [0.1, 0.2, 0.3], 0.4, 0.3, 0.2), &rod, Owner::VertexOfAEdgeOfB(0, 0), "ball, side"),
        (&ball, on(39, [0.1, 0.2, 0.3], 0.3, 0.2, 0.8), &rod, Owner::Curved(Feature::Vertex(0), rim(1)), "ball, rim"),
        (&capsule, on(40, [0.2, -0.9, 0.0], 0.5, 0.2, 0.7), &rod, Owner::Curved(side, rim(1)), "capsule, rim"),
        (&coin, on(41, [0.7, 0.6, 0.1], 0.6, 0.2, 0.1), &rod, Owner::Curved(rim(0), side), "rim, side"),
        (&rod, on(42, [1.2, 0.1, 0.0], 0.5, 0.1, 0.1), &rod, Owner::Edges(0, 0), "sides"),
        (&coin, on(43, [0.3, 0.9, 0.0], 0.5, 0.3, 0.75), &rod, Owner::Curved(rim(0), rim(1)), "rims"),
    ];
    for (a, pa, b, owner, name) in cases {
        check_touching(Pair::new(a, pa, b, base), owner, name);
    }
}

/// A placement on top of `base` at the height `z`, turned by `rotation`, with a relative angular velocity along
/// the normal.
fn on_top(base: &Placement, rotation: Matrix3<f64>, x: f64, y: f64, z: f64, seed: u64) -> Placement {
    let n: Vector3<f64> = base.rotation.column(2).into();
    let rotation = base.rotation * rotation;
    let moved = moving(seed, rotation, 0.0, 0.0, 0.0);
    Placement { position: base.point(&Vector3::new(x, y, z)), omega: base.omega + n * 0.8, ..moved }
}

/// Flat patches of all kinds: their corners, and the rates of each.
#[test]
fn flat_patches_with_cylinders_have_exact_corners_and_rates() {
    let lying = turn(Vector3::z() * 0.3) * turn(Vector3::y() * FRAC_PI_2);
    let capsule = ConvexBody::capsule(0.5, 0.1);
    let upright = turn(Vector3::z() * 0.2);
    let square = ConvexBody::cuboid(Vector3::new(0.3, 0.25, 0.2));
    // A, its pose on B, B, its height and face; number of corners of A, B and crossings.
    type Case<'a> = (&'a ConvexBody, Matrix3<f64>, [f64; 2], &'a ConvexBody, f64, u16, [usize; 3]);
    let (rod, coin, cube) = (rod(), coin(), cube());
    let cases: [Case; 8] = [
        (&rod, lying, [0.3, 0.0], &cube, 0.5, 5, [1, 0, 1]),
        (&rod, upright, [0.0, 0.0], &cube, 0.8, 5, [RING, 0, 0]),
        (&rod, upright, [0.45, 0.0], &cube, 0.8, 5, [10, 0, 2]),
        (&coin, upright, [0.4, 0.3], &cube, 0.35, 5, [6, 1, 2]),
        (&coin, upright, [0.35, 0.1], &coin, 0.1, 1, [5, 6, 2]),
        (&square, upright, [0.2, 0.1], &coin, 0.25, 1, [2, 3, 2]),
        (&rod, lying, [0.0, 0.1], &coin, 0.25, 1, [0, 0, 2]),
        (&capsule, lying, [0.2, 0.1], &coin, 0.15, 1, [1, 0, 1]),
    ];
    for (k, (a, rotation, [x, y], b, z, face, expected)) in cases.into_iter().enumerate() {
        let base = moving(50 + k as u64, turn(Vector3::new(0.3, 0.2, 0.1)), 0.1, 0.2, 0.3);
        let pair = Pair::new(a, on_top(&base, rotation, x, y, z, 60 + k as u64), b, base);
        for (pair, owner, expected) in [
            (pair.clone(), Owner::FaceOfB(face), expected),
            (pair.swapped(), Owner::FaceOfA(face), [expected[1], expected[0], expected[2]]),
        ] {
            let topology = pair.topology(owner, 1e-9);
            let mut count = [0; 3];
            for corner in &topology.corners {
                count[match corner {
                    Corner::A(_) => 0,
                    Corner::B(_) => 1,
                    Corner::Crossing { .. } => 2,
                }] += 1;
            }
            assert_eq!(count, expected, "{k}: {topology:?}");
            assert_eq!(check(&pair, &topology, 1e-9, "flat"), topology.corners.len());
            assert!(pair.validity(&topology) > 0.0);
            let at = pair.geometry(&topology);
            let flat: Vec<_> = at.points.iter().map(|p| at.axes.tr_mul(&p.position).xy()).collect();
            let count = flat.len();
            for k in 0..if count > 2 { count } else { 0 } {
                let (p, q, r) = (flat[k], flat[(k + 1) % count], flat[(k + 2) % count]);
                assert!((q - p).perp(&(r - q)) > 0.0, "{topology:?}");
            }
        }
    }
}

/// The area of the polygon of two equal discs is that of their lens, up to the arcs between neighbours, of
/// which each has at most R^2 (h - sin h)/2 with h = 2 pi/RING.
#[test]
fn the_polygon_of_two_discs_is_inscribed_in_their_lens() {
    let (r, d): (f64, f64) = (0.4, 0.35);
    let pair = Pair::new(&coin(), level(d, 0.0, 0.1), &coin(), level(0.0, 0.0, 0.0));
    let at = pair.geometry(&pair.topology(Owner::FaceOfB(1), 1e-9));
    let flat: Vec<_> = at.points.iter().map(|p| p.position.xy()).collect();
    let area = (0..flat.len()).map(|k| flat[k].perp(&flat[(k + 1) % flat.len()])).sum::<f64>() / 2.0;
    let lens = 2.0 * r * r * (d / (2.0 * r)).acos() - 0.5 * d * (4.0 * r * r - d * d).sqrt();
    let h = TAU / RING as f64;
    assert!(area < lens && area > lens - flat.len() as f64 * r * r * (h - h.sin()) / 2.0, "{area} {lens}");
    let crossing = at.points.iter().map(|p| p.position.y).fold(0.0, f64::max);
    assert!((crossing - (r * r - d * d / 4.0).sqrt()).abs() < 1e-12);
}

/// Parallel edges: both corners, at any inclination about the axis across n and e.
#[test]
fn parallel_edges_have_two_corners_with_exact_rates() {
    let capsule = |half: f64| ConvexBody::capsule(half, 0.1);
    let quarter = turn(Vector3::x() * FRAC_PI_2) * turn(Vector3::z() * (PI / 4.0));
    let roof = ConvexBody::cuboid(Vector3::new(0.3, 0.3, 0.6));
    // B's uppermost edge or side is along y at x = z = 0 after the shift.
    let along = turn(Vector3::x() * FRAC_PI_2);
    // A, B, its rotation and height; number of corners of A and of B.
    type Case = (ConvexBody, ConvexBody, Matrix3<f64>, f64, [usize; 2]);
    let cases: [Case; 6] = [
        (capsule(0.5), capsule(0.3), along, 0.1, [1, 1]),
        (capsule(0.2), roof.clone(), quarter, 0.3 * 2.0f64.sqrt(), [2, 0]),
        (capsule(0.5), rod(), along, 0.2, [1, 1]),
        (rod(), roof, quarter, 0.3 * 2.0f64.sqrt(), [1, 1]),
        (rod(), rod(), along, 0.2, [1, 1]),
        (rod(), ConvexBody::cylinder(0.1, 0.3), along, 0.3, [0, 2]),
    ];
    for (k, (a, b, rotation, top, expected)) in cases.into_iter().enumerate() {
        let radius = a.edge_rounding();
        let shift = if expected == [1, 1] { 0.35 } else { 0.0 };
        let pb = moving(70 + k as u64, rotation, 0.0, 0.0, -top);
        let mut pa = moving(80 + k as u64, along, 0.0, shift, radius);
        let pair = Pair::new(&a, pa, &b, pb);
        let found = pair.separation();
        assert!(found.distance.abs() < 1e-12 && matches!(found.owner, Some(Owner::Along(..))), "{k}: {found:?}");
        let held = pair.topology(found.owner.unwrap(), 1e-9);
        let count = |of_a: bool| held.corners.iter().filter(|c| matches!(c, Corner::A(_)) == of_a).count();
        assert_eq!([count(true), count(false)], expected, "{k}: {held:?}");
        assert!(pair.validity(&held) > 0.0);
        let at = pair.geometry(&held);
        assert!((at.axes.column(2) - Vector3::z()).norm() < 1e-12);
        assert!(at.points.iter().all(|p| p.gap.abs() < 1e-12 && p.position.xz().norm() < 1e-12), "{k}: {at:?}");
        check_corners(&pair, &held);
        check_corners(&pair.swapped(), &pair.swapped().topology(swap(held.owner), 1e-9));
        // Inclined: the lower end stays, and the corners are those of the nearest points.
        pa.rotation = turn(Vector3::x() * 0.2) * pa.rotation;
        check_corners(&Pair::new(&a, pa, &b, pb), &held);
        // Turned about n, the edges cross: the patch ends when they are lower by 1e-9 between the corners.
        let turned =
            |angle: f64| Pair::new(&a, Placement { rotation: turn(Vector3::z() * angle) * along, ..pa }, &b, pb);
        let lasts = |angle: f64| turned(angle).validity(&held);
        assert!(lasts(1e-6) > 0.0 && lasts(1e-3) < 0.0, "{k}: {} {}", lasts(1e-6), lasts(1e-3));
        assert!(!matches!(turned(1e-3).separation().owner, Some(Owner::Along(..))));
    }
}

/// Rates of gaps and of their rates. n' is that of each corner's own nearest points, so that only the parts along
/// n are compared.
fn check_corners(pair: &Pair, held: &Topology) {
    let accelerations = [Vector3::new(0.3, -0.7, 0.4), Vector3::new(-0.5, 0.2, 0.9)];
    let of = |t: f64| advance(pair, &accelerations, t).geometry(held);
    let now = of(0.0);
    for (k, corner) in now.points.iter().enumerate() {
        let Owner::Along(i, j) = held.owner else { panic!("{held:?}") };
        let (a, b) = ((&pair.a, &pair.pa), (&pair.b, &pair.pb));
        let n = parallel::corner_pin((i, j), &held.corners[k], a, b).0.n;
        let gap_rate = rate(|t| Vector3::x() * of(t).points[k].gap).x;
        assert!((gap_rate - n.dot(&corner.velocity)).abs() < 1e-9, "{held:?} {gap_rate}");
        let gap_second = second(|t| of(t).points[k].gap);
        let expected = n.dot(&(accelerations[0] - accelerations[1] + corner.bias));
        assert!((gap_second - expected).abs() < 1e-6, "{held:?} {gap_second} {expected}");
    }
}

/// A cylinder that rolls without slip on a fixed plane has no bias.
#[test]
fn a_cylinder_that_rolls_has_no_bias() {
    let lying = turn(Vector3::x() * FRAC_PI_2);
    let mut pa = at(lying, 0.3, 0.1, 0.2);
    pa.velocity = Vector3::new(0.8, 0.0, 0.0);
    pa.omega = Vector3::y() * 4.0;
    let pair = Pair::new(&rod(), pa, &ConvexBody::half_space(), level(0.0, 0.0, 0.0));
    let points = pair.geometry(&pair.topology(Owner::FaceOfB(0), 1e-9)).points;
    assert_eq!(points.len(), 2);
    assert!(points.iter().all(|p| p.velocity.norm() < 1e-15 && p.bias.norm() < 1e-15), "{points:?}");
}
