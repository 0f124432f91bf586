//! Gaps, velocities and bias accelerations against finite differences along curved motions.
//!
//! Errors: the extrapolated central differences with the step h have h^4 f^(5), about 1e-10 for the
//! fastest motions, and roundoff, 1e-16/h = 3e-13 for first and 1e-16/h^2 = 1e-9 for second differences.

use super::*;

const H: f64 = 3e-4;

/// The pair after the time `t`, with constant angular velocities and accelerations of the origins.
pub fn advance(pair: &Pair, accelerations: &[Vector3<f64>; 2], t: f64) -> Pair {
    let move_one = |p: &Placement, a: &Vector3<f64>| Placement {
        rotation: turn(p.omega * t) * p.rotation,
        position: p.position + p.velocity * t + a * (t * t / 2.0),
        velocity: p.velocity + a * t,
        omega: p.omega,
    };
    Pair { pa: move_one(&pair.pa, &accelerations[0]), pb: move_one(&pair.pb, &accelerations[1]), ..pair.clone() }
}

/// First derivative of `f` at zero.
pub fn rate(f: impl Fn(f64) -> Vector3<f64>) -> Vector3<f64> {
    let central = |h: f64| (f(h) - f(-h)) / (2.0 * h);
    (central(H / 2.0) * 4.0 - central(H)) / 3.0
}

/// Second derivative of `f` at zero.
pub fn second(f: impl Fn(f64) -> f64) -> f64 {
    let central = |h: f64| (f(h) - 2.0 * f(0.0) + f(-h)) / (h * h);
    (4.0 * central(2.0 * H) - central(4.0 * H)) / 3.0
}

/// Checks all corners of a topology with gaps up to `near`; returns their number.
pub fn check(pair: &Pair, topology: &Topology, near: f64, name: &str) -> usize {
    let accelerations = [Vector3::new(0.3, -0.7, 0.4), Vector3::new(-0.5, 0.2, 0.9)];
    let of = |t: f64| advance(pair, &accelerations, t).geometry(topology);
    let now = of(0.0);
    let n: Vector3<f64> = now.axes.column(2).into();
    assert!((now.axes.transpose() * now.axes - Matrix3::identity()).norm() < 1e-12, "{name}");
    let n_rate = rate(|t| of(t).axes.column(2).into());
    let mut count = 0;
    for (k, corner) in now.points.iter().enumerate() {
        if corner.gap.abs() > near {
            continue;
        }
        count += 1;
        let case = format!("{name}, {:?}, {:?}", topology.owner, topology.corners[k]);
        let gap_rate = rate(|t| Vector3::x() * of(t).points[k].gap).x;
        assert!((gap_rate - n.dot(&corner.velocity)).abs() < 1e-9, "{case}: {gap_rate}");
        let measured = rate(|t| of(t).points[k].velocity) + n * n_rate.dot(&corner.velocity);
        let expected = accelerations[0] - accelerations[1] + corner.bias;
        assert!((measured - expected).norm() < 1e-8, "{case}: {measured} {expected}");
        let gap_second = second(|t| of(t).points[k].gap);
        assert!((gap_second - n.dot(&expected)).abs() < 1e-6, "{case}: {gap_second} {}", n.dot(&expected));
    }
    count
}

/// Brings a pair to contact, gives it velocities, and checks it and its mirror image.
pub fn check_touching(mut pair: Pair, expected: Owner, name: &str) {
    let owner = pair.touch();
    assert_eq!(owner, expected, "{name}");
    for gap in [0.0, 0.01] {
        let normal = kinematics::plane_normal(owner, &pair.a, &pair.pa, &pair.b, &pair.pb);
        pair.pa.position += normal * gap;
        let topology = pair.topology(owner, 0.02);
        assert!(check(&pair, &topology, 0.011, name) > 0);
        let mirror = pair.swapped();
        let topology = mirror.topology(swap(owner), 0.02);
        assert!(check(&mirror, &topology, 0.011, name) > 0);
    }
}

pub fn moving(seed: u64, rotation: Matrix3<f64>, x: f64, y: f64, z: f64) -> Placement {
    let mut random = Random::new(seed);
    let (velocity, omega) = (random.vector(), random.vector() * 2.0);
    Placement { velocity, omega, ..at(rotation, x, y, z) }
}

#[test]
fn flat_faces_have_exact_rates_at_vertices_of_both_and_crossings() {
    let mut random = Random::new(5);
    for _ in 0..20 {
        let base = random.placement();
        let (half_a, half_b) = (Vector3::new(0.5, 0.3, 0.2), Vector3::new(0.4, 0.35, 0.1));
        let (a, b) = (ConvexBody::cuboid(half_a), ConvexBody::cuboid(half_b));
        let n: Vector3<f64> = base.rotation.column(2).into();
        let shift = Vector3::new(0.3 * random.next(), 0.3 * random.next(), 0.3);
        let pa = Placement {
            rotation: base.rotation * turn(Vector3::z() * (3.0 * random.next())),
            position: base.point(&shift),
            velocity: random.vector(),
            omega: base.omega + n * random.next(),
        };
        let pair = Pair::new(&a, pa, &b, base);
        let topology = pair.topology(Owner::FaceOfB(5), 1e-9);
        assert_eq!(check(&pair, &topology, 1e-9, "flat"), topology.corners.len());
        assert!(topology.corners.iter().any(|c| matches!(c, Corner::Crossing { .. })));
        let mirror = pair.swapped();
        let topology = mirror.topology(Owner::FaceOfA(5), 1e-9);
        assert_eq!(check(&mirror, &topology, 1e-9, "flat, mirrored"), topology.corners.len());
    }
}

#[test]
fn vertices_and_edges_on_faces_have_exact_rates() {
    let (a, b) = (ConvexBody::cuboid(Vector3::new(0.3, 0.2, 0.1)), ConvexBody::cuboid(Vector3::new(1.0, 1.0, 0.5)));
    let tilted = moving(1, turn(Vector3::new(0.4, 0.3, 0.2)), 0.1, 0.2, 1.0);
    check_touching(
        Pair::new(&a, tilted, &b, moving(2, Matrix3::identity(), 0.0, 0.0, 0.0)),
        Owner::FaceOfB(5),
        "vertex",
    );
    let on_edge = moving(3, turn(Vector3::y() * 0.4), 0.1, 0.2, 1.0);
    check_touching(
        Pair::new(&a, on_edge, &b, moving(4, Matrix3::identity(), 0.0, 0.0, 0.0)),
        Owner::FaceOfB(5),
        "edge",
    );
    let ground = ConvexBody::half_space();
    let mut pair = Pair::new(&a, tilted, &ground, moving(5, turn(Vector3::new(0.2, 0.1, 0.0)), 0.0, 0.0, 0.0));
    assert_eq!(pair.touch(), Owner::FaceOfB(0));
    assert!(check(&pair, &pair.topology(Owner::FaceOfB(0), 1e-9), 1e-9, "ground") > 0);
}

#[test]
fn crossed_edges_have_exact_rates() {
    let b = ConvexBody::cuboid(Vector3::new(0.5, 0.5, 2.0));
    let a = ConvexBody::cuboid(Vector3::new(0.4, 0.4, 1.5));
    let quarter = std::f64::consts::FRAC_PI_4;
    // B's edge points along y and up, A's along x and down.
    let pb = moving(6, turn(Vector3::x() * (2.0 * quarter)) * turn(Vector3::z() * quarter), 0.0, 0.0, 0.0);
    let pa = moving(7, turn(Vector3::y() * (2.0 * quarter)) * turn(Vector3::z() * (quarter + 0.1)), 0.1, 0.2, 1.6);
    let mut pair = Pair::new(&a, pa, &b, pb);
    let owner = pair.touch();
    assert!(matches!(owner, Owner::Edges(..)), "{owner:?}");
    check_touching(pair, owner, "edges");
}

#[test]
fn rounded_bodies_have_exact_rates() {
    let (ball, capsule) = (ConvexBody::ball(0.3), ConvexBody::capsule(0.5, 0.1));
    let cube = ConvexBody::cuboid(Vector3::new(0.5, 0.6, 0.7));
    let ground = ConvexBody::half_space();
    let still = moving(11, Matrix3::identity(), 0.0, 0.0, 0.0);
    let mid = |x: f64, y: f64, z: f64| moving(12, turn(Vector3::new(0.1, 0.2, 0.3)), x, y, z);
    let top = |edge: [u16; 2]| {
        let is = |e: &Edge| e.ends == edge || e.ends == [edge[1], edge[0]];
        cube.edges.iter().position(is).unwrap() as u16
    };
    check_touching(Pair::new(&ball, mid(0.1, 0.2, 1.2), &ground, still), Owner::FaceOfB(0), "ball, ground");
    check_touching(Pair::new(&ball, mid(0.1, 0.2, 1.2), &cube, still), Owner::FaceOfB(5), "ball, face");
    // The upper edge at x = 0.5 runs between the vertices 5 and 7.
    check_touching(
        Pair::new(&ball, mid(0.9, 0.2, 1.0), &cube, still),
        Owner::VertexOfAEdgeOfB(0, top([5, 7])),
        "ball, edge",
    );
    check_touching(Pair::new(&ball, mid(0.9, 1.0, 1.0), &cube, still), Owner::VertexVertex(0, 7), "ball, vertex");
    check_touching(Pair::new(&ball, mid(0.9, 1.0, 1.0), &ball, still), Owner::VertexVertex(0, 0), "ball, ball");
    check_touching(Pair::new(&ball, mid(0.9, 0.1, 0.2), &capsule, still), Owner::VertexOfAEdgeOfB(0, 0), "ball, rod");
    let lying = moving(13, turn(Vector3::y() * 1.4), 0.0, 0.1, 1.2);
    check_touching(Pair::new(&capsule, lying, &cube, still), Owner::FaceOfB(5), "capsule, face");
    let across = moving(14, turn(Vector3::y() * 2.2), 0.55, 0.1, 1.0);
    check_touching(Pair::new(&capsule, across, &cube, still), Owner::Edges(0, top([5, 7])), "capsule, edge");
    let crossed = moving(15, turn(Vector3::x() * 1.2), 0.3, 0.05, 0.0);
    check_touching(Pair::new(&capsule, crossed, &capsule, still), Owner::Edges(0, 0), "capsules");
    // A capsule's end and a corner of the cube on its side.
    let end = moving(16, turn(Vector3::y() * 0.6), 0.9, 0.2, 1.2);
    check_touching(Pair::new(&capsule, end, &cube, still), Owner::VertexOfAEdgeOfB(0, top([5, 7])), "end, edge");
    let side = moving(17, turn(Vector3::new(0.5, -0.5, 0.0)), 0.7, 0.8, 0.9);
    check_touching(Pair::new(&capsule, side, &cube, still), Owner::EdgeOfAVertexOfB(0, 7), "side, vertex");
}

/// A lying capsule that overhangs a border has one vertex and one crossing.
#[test]
fn a_capsule_across_a_border_has_exact_rates() {
    let (capsule, cube) = (ConvexBody::capsule(0.5, 0.1), ConvexBody::cuboid(Vector3::new(0.5, 0.5, 0.5)));
    let pb = moving(21, turn(Vector3::new(0.2, 0.3, 0.1)), 0.0, 0.0, 0.0);
    let n: Vector3<f64> = pb.rotation.column(2).into();
    let rotation = pb.rotation * turn(Vector3::z() * 0.3) * turn(Vector3::y() * std::f64::consts::FRAC_PI_2);
    let mut pa = moving(22, rotation, 0.0, 0.0, 0.0);
    pa.position = pb.point(&Vector3::new(0.4, 0.0, 0.6));
    pa.omega = pb.omega + n * 0.7;
    let pair = Pair::new(&capsule, pa, &cube, pb);
    let topology = pair.topology(Owner::FaceOfB(5), 1e-9);
    assert_eq!(topology.corners.len(), 2);
    assert_eq!(check(&pair, &topology, 1e-9, "capsule"), 2);
}

#[test]
fn a_ball_that_rolls_without_slip_on_a_fixed_plane_has_no_bias() {
    let (ball, ground) = (ConvexBody::ball(0.25), ConvexBody::half_space());
    let mut pa = level(0.3, 0.1, 0.25);
    pa.velocity = Vector3::new(0.8, -0.4, 0.0);
    pa.omega = Vector3::z().cross(&pa.velocity) / 0.25 + Vector3::z() * 0.9;
    let pair = Pair::new(&ball, pa, &ground, level(0.0, 0.0, 0.0));
    let points = pair.geometry(&pair.topology(Owner::FaceOfB(0), 1e-9)).points;
    assert!(points[0].velocity.norm() < 1e-15 && points[0].bias.norm() < 1e-15, "{points:?}");
}

/// The gaps and the components of velocities and biases in the patch axes do not depend on the
/// frame of the world. Error: roundoff.
#[test]
fn a_common_rigid_displacement_changes_nothing_in_patch_axes() {
    let mut random = Random::new(31);
    let bodies =
        [ConvexBody::cuboid(Vector3::new(0.5, 0.4, 0.3)), ConvexBody::ball(0.2), ConvexBody::capsule(0.4, 0.2)];
    for k in 0..60 {
        let mut pair = Pair::new(&bodies[k % 3], random.placement(), &bodies[k % 2], random.placement());
        pair.pa.position = random.direction() * 3.0;
        let owner = pair.touch();
        let moved = pair.moved(&turn(random.vector() * 3.0), &random.vector());
        let topology = pair.topology(owner, 1e-6);
        let (one, two) = (pair.geometry(&topology), moved.geometry(&topology));
        assert!((pair.validity(&topology) - moved.validity(&topology)).abs() < 1e-12);
        for (p, q) in one.points.iter().zip(&two.points) {
            assert!((p.gap - q.gap).abs() < 1e-12 * (1.0 + p.gap.abs()));
            for (u, v) in [(p.velocity, q.velocity), (p.bias, q.bias)] {
                let size = 1.0 + u.norm();
                assert!((one.axes.tr_mul(&u) - two.axes.tr_mul(&v)).norm() < 1e-9 * size, "{owner:?} {u} {v}");
            }
        }
    }
}
