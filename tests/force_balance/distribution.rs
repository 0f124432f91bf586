//! The distribution of a wrench over contacts against closed forms and optimality conditions.

use crate::identities::random_tree::Random;
use crate::support::counting::count;
use nalgebra::{Matrix3, Vector3};
use stiction::task::balance::distribution::{Distribution, Measure, VERTICAL, Wrench};

const WEIGHT: f64 = 70.0;
const MU: f64 = 0.5;

fn measure(length: f64) -> Measure {
    Measure { force: WEIGHT, length, up: Vector3::z() }
}

fn wrench(force: [f64; 3], moment: [f64; 3]) -> Wrench {
    Wrench { force: force.into(), moment: moment.into() }
}

/// Contacts with the normal z.
fn flat(arms: &[[f64; 3]]) -> Distribution {
    let mut d = Distribution::new(arms.len());
    arms.iter().for_each(|a| d.add((*a).into(), Vector3::z()));
    d
}

/// Two soles of 0.2 x 0.1 m, 0.2 m apart, `height` below the reference point.
fn feet(height: f64) -> Vec<[f64; 3]> {
    let corners = |y: f64| {
        [[0.1, y + 0.05, -height], [-0.1, y + 0.05, -height], [-0.1, y - 0.05, -height], [0.1, y - 0.05, -height]]
    };
    [corners(0.1), corners(-0.1)].concat()
}

fn distance(a: &Wrench, b: &Wrench) -> f64 {
    (a.force - b.force).norm() + (a.moment - b.moment).norm()
}

#[test]
fn the_weight_is_shared_equally_by_all_corners() {
    let mut d = flat(&feet(0.6));
    let expected = wrench([0.0, 0.0, WEIGHT], [0.0; 3]);
    let got = d.solve(&expected, MU, &measure(0.1));
    assert!(distance(&got, &expected) < 1e-12 * WEIGHT, "{got:?}");
    for f in d.forces() {
        // Rounding of a 6 x 6 solution.
        assert!((f - Vector3::new(0.0, 0.0, WEIGHT / 8.0)).norm() < 1e-12 * WEIGHT, "{f}");
    }
}

#[test]
fn a_moment_tilts_the_pressure() {
    // On a square of half width a the field is F/4 - M x / (4 a^2), and a yaw moment turns by N
    // (-y, x) / (8 a^2).
    let a = 0.1;
    let mut d = flat(&[[a, a, 0.0], [-a, a, 0.0], [-a, -a, 0.0], [a, -a, 0.0]]);
    let (m, n) = (1.2, 0.4);
    let expected = wrench([0.0, 0.0, WEIGHT], [0.0, m, n]);
    let got = d.solve(&expected, MU, &measure(0.1));
    assert!(distance(&got, &expected) < 1e-12 * WEIGHT, "{got:?}");
    for (f, (x, y)) in d.forces().iter().zip([(a, a), (-a, a), (-a, -a), (a, -a)]) {
        let closed = Vector3::new(-y, x, 0.0) * (n / (8.0 * a * a))
            + Vector3::new(0.0, 0.0, WEIGHT / 4.0 - m * x / (4.0 * a * a));
        assert!((f - closed).norm() < 1e-12 * WEIGHT, "{f} {closed}");
    }
}

#[test]
fn no_contact_pulls() {
    // Three pairs of points at x = -1, 0, 1; the centre of pressure at 3/4. The least-norm field
    // would pull at -1 by an eighth of a third. The least norm with f >= 0 is 0, 1/4 and 3/4 of the
    // weight on the pairs.
    let points: Vec<[f64; 3]> = [-1.0, 0.0, 1.0].iter().flat_map(|x| [[*x, 0.5, 0.0], [*x, -0.5, 0.0]]).collect();
    let mut d = flat(&points);
    let expected = wrench([0.0, 0.0, WEIGHT], [0.0, -0.75 * WEIGHT, 0.0]);
    let got = d.solve(&expected, MU, &measure(1.0));
    assert!(distance(&got, &expected) < 1e-12 * WEIGHT, "{:e}", distance(&got, &expected));
    for (f, share) in d.forces().iter().zip([0.0, 0.0, 0.125, 0.125, 0.375, 0.375]) {
        // The sums are exact; the distribution is a stationary point, as exact as its gradient.
        assert!((f - Vector3::new(0.0, 0.0, share * WEIGHT)).norm() < 1e-10 * WEIGHT, "{f} {share}");
    }
}

#[test]
fn a_centre_of_pressure_outside_the_soles_is_clamped_to_their_edge() {
    let (height, length) = (0.6, 0.12);
    let mut d = flat(&feet(height));
    // The centre of pressure of this wrench would be 0.6 * 0.4 = 0.24 m behind; the heels are at
    // 0.1 m.
    let expected = wrench([0.4 * WEIGHT, 0.0, WEIGHT], [0.0; 3]);
    let got = d.solve(&expected, MU, &measure(length));
    let forces = d.forces();
    for (f, arm) in forces.iter().zip(feet(height)) {
        assert!(arm[0] < 0.0 || f.norm() == 0.0, "a toe carries {f}");
    }
    // The nearest wrench gives up the push rather than the weight or the upright body.
    assert!((got.force.z / WEIGHT - 1.0).abs() < 0.02, "{got:?}");
    assert!(got.moment.norm() < 0.02 * WEIGHT * height && got.force.x > 0.1 * WEIGHT, "{got:?}");
    // With no other active constraint it is the point on the ray of heel forces (x, z), moment
    // about y = x (-height) + 0.1 z, nearest in the norm: two linear equations.
    let (g, w) = (VERTICAL * VERTICAL, 1.0 / (length * length));
    let (a, b, c) = (1.0 + w * height * height, -w * height * 0.1, g + w * 0.01);
    let (p, q) = (0.4 * WEIGHT, g * WEIGHT);
    let (x, z) = ((p * c - b * q) / (a * c - b * b), (a * q - b * p) / (a * c - b * b));
    // The error is the last weight of the method of multipliers, 1e-5.
    assert!((got.force.x - x).abs() < 1e-4 * WEIGHT && (got.force.z - z).abs() < 1e-4 * WEIGHT, "{got:?} {x} {z}");
}

#[test]
fn forces_stay_in_their_cones_and_add_up_where_feasible() {
    let mut r = Random::new(11);
    for _ in 0..300 {
        let arms = feet(0.5 + r.within(0.0, 0.3));
        let mut d = Distribution::new(arms.len());
        let mut expected = wrench([0.0; 3], [0.0; 3]);
        for (i, arm) in arms.iter().enumerate() {
            // The second sole is tilted. Forces inside the cones make the wrench, so it is
            // feasible.
            let normal = Vector3::new(if i < 4 { 0.0 } else { 0.3 }, 0.0, 1.0).normalize();
            let arm = Vector3::from(*arm);
            d.add(arm, normal);
            let side = normal.cross(&r.vector(1.0)).normalize();
            let f = (normal + side * (MU * 0.98 * r.within(0.0, 1.0))) * (r.within(-1.0, 1.0).max(0.0) * WEIGHT / 4.0);
            expected.force += f;
            expected.moment += arm.cross(&f);
        }
        let got = d.solve(&expected, MU, &measure(0.15));
        assert!(distance(&got, &expected) < 1e-12 * WEIGHT, "{:e}", distance(&got, &expected));
        inside(&d);
    }
}

fn inside(d: &Distribution) {
    for (i, f) in d.forces().iter().enumerate() {
        let normal = Vector3::new(if i < 4 { 0.0 } else { 0.3 }, 0.0, 1.0).normalize();
        let n = f.dot(&normal);
        assert!((f - normal * n).norm() <= MU * n + 1e-13 * WEIGHT, "{f}");
    }
}

#[test]
fn an_infeasible_wrench_gives_the_nearest_one() {
    // At the nearest wrench no force that the cones allow comes nearer. With rho the missing
    // wrench, scaled, the projection of G^T rho on each cone is zero, and so is its power with the
    // forces.
    let mut r = Random::new(12);
    let length = 0.15;
    let lift = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, VERTICAL));
    let mut beyond = 0;
    for _ in 0..200 {
        let arms = feet(0.7);
        let mut d = Distribution::new(arms.len());
        for (i, arm) in arms.iter().enumerate() {
            let normal = Vector3::new(if i < 4 { 0.0 } else { 0.3 }, 0.0, 1.0).normalize();
            d.add((*arm).into(), normal);
        }
        let expected = Wrench { force: r.vector(WEIGHT), moment: r.vector(0.3 * WEIGHT) };
        let got = d.solve(&expected, MU, &measure(length));
        inside(&d);
        let (force, moment) = (lift * (expected.force - got.force), (expected.moment - got.moment) / length);
        let missing = (force.norm_squared() + moment.norm_squared()).sqrt();
        if missing < 1e-9 * WEIGHT {
            continue;
        }
        beyond += 1;
        let mut power = 0.0;
        for (i, (arm, f)) in arms.iter().zip(d.forces()).enumerate() {
            let arm = Vector3::from(*arm);
            let normal = Vector3::new(if i < 4 { 0.0 } else { 0.3 }, 0.0, 1.0).normalize();
            let way = lift * force + moment.cross(&arm) / length;
            let (n, t) = (way.dot(&normal), (way - normal * way.dot(&normal)).norm());
            // The greatest power of a unit force in the cone along `way`.
            let gain = (n + MU * t) / (1.0 + MU * MU).sqrt();
            // The weight 1e-5 of the method and the number of contacts, times the stiffest
            // direction, VERTICAL^2.
            assert!(gain < 1e-3 * missing * VERTICAL, "{gain} {missing}");
            power += way.dot(f);
        }
        let size = d.forces().iter().map(|f| f.norm()).sum::<f64>();
        assert!(power.abs() < 1e-3 * missing * size.max(WEIGHT), "{power} {missing} {size}");
    }
    assert!(beyond > 100, "{beyond}");
}

#[test]
fn degenerate_contacts_give_the_nearest_wrench() {
    let expected = wrench([0.0, 0.0, WEIGHT], [0.0; 3]);
    let none = Distribution::new(0).solve(&expected, MU, &measure(0.1));
    assert_eq!(none, wrench([0.0; 3], [0.0; 3]));
    // One point below the centre of mass carries the weight; so does a line.
    for arms in [vec![[0.0, 0.0, -0.5]], vec![[0.1, 0.0, -0.5], [-0.1, 0.0, -0.5]]] {
        let got = flat(&arms).solve(&expected, MU, &measure(0.1));
        assert!(distance(&got, &expected) < 1e-12 * WEIGHT, "{got:?}");
    }
    // Nothing pulls the robot down.
    let mut d = flat(&feet(0.6));
    d.solve(&wrench([0.0, 0.0, -WEIGHT], [0.0; 3]), MU, &measure(0.1));
    assert!(d.forces().iter().all(|f| f.norm() == 0.0), "{:?}", d.forces());
}

#[test]
fn distribution_allocates_nothing() {
    let arms = feet(0.6);
    let mut d = Distribution::new(arms.len());
    let allocations = count(|| {
        for force in [[0.0, 0.0, WEIGHT], [0.4 * WEIGHT, 0.0, WEIGHT]] {
            d.clear();
            arms.iter().for_each(|a| d.add((*a).into(), Vector3::z()));
            d.solve(&wrench(force, [0.0; 3]), MU, &measure(0.1));
        }
    });
    assert_eq!(allocations, 0);
}
