//! Footstep plan, Riccati equation and preview control.

use nalgebra::{Matrix4, Vector3, Vector4};
use stiction::linalg::riccati;
use stiction::task::gait::{Footsteps, Preview, Stride};

#[test]
fn the_riccati_solution_has_its_closed_form() {
    // The input affects the first state alone and the others decay at no cost. Only p_00 = p
    // remains of the equation: p = q + a^2 p r / (r + b^2 p), a quadratic in p.
    for (a, b, q, r) in [(1.0, 0.5, 2.0, 0.1), (1.3, 0.2, 1.0, 1e-3), (0.7, 1.0, 0.5, 10.0)] {
        let system = Matrix4::from_diagonal(&Vector4::new(a, 0.5, -0.2, 0.1));
        let cost = Matrix4::from_diagonal(&Vector4::new(q, 0.0, 0.0, 0.0));
        let found = riccati::solve(&system, &Vector4::new(b, 0.0, 0.0, 0.0), &cost, r).unwrap();
        let linear = r - a * a * r - b * b * q;
        let p = (-linear + (linear * linear + 4.0 * b * b * q * r).sqrt()) / (2.0 * b * b);
        // Rounding of some tens of operations.
        assert!((found.p[(0, 0)] - p).abs() < 1e-12 * p, "{} {p}", found.p[(0, 0)]);
        assert!(found.residual < 1e-13);
    }
    // Unstable and not controllable: nothing stabilises it.
    let lost = Matrix4::from_diagonal(&Vector4::new(0.5, 2.0, 0.1, 0.1));
    assert_eq!(riccati::solve(&lost, &Vector4::x(), &Matrix4::identity(), 1.0), None);
}

/// Height, period, state gains, preview gains, P_11.
type Row = (f64, f64, [f64; 4], [f64; 4], f64);

/// Height, period, (G_i, G_x), G_p(1), G_p(2), G_p(10), G_p(100), P_11 by
/// `scipy.linalg.solve_discrete_are` of SciPy 1.17.1, g = 9.81, R = 1e-6; see make_preview.py.
const SCIPY: [Row; 3] = [
    (
        0.26,
        0.005,
        [749.3063909400514, 51747.191576044046, 9063.53652594346, 110.15121451494909],
        [-749.3063909400514, -823.6981686544667, -1284.21808467463, -79.60331147568745],
        84415.42740635596,
    ),
    (
        0.814,
        0.005,
        [618.7016237876707, 72719.43894295486, 21549.597698240294, 177.01265672878807],
        [-618.7016237876707, -777.5073305102235, -1103.335177655544, -229.01973321444058],
        406877.51753775246,
    ),
    (
        0.9,
        0.02,
        [340.217449403345, 10749.896496849879, 3504.1582161513647, 78.53752675112794],
        [-340.217449403345, -552.4446103733479, -396.15587318075325, -1.038788452415153],
        7707.098928847305,
    ),
];

#[test]
fn gains_agree_with_scipy() {
    for (height, period, [integral, c, speed, acceleration], ahead, p) in SCIPY {
        let found = Preview::new(height, 9.81, period, 320.0 * period).unwrap();
        assert!(found.riccati.residual < 1e-10, "{:e}", found.riccati.residual);
        let truth = [integral, c, speed, acceleration, ahead[0], ahead[1], ahead[2], ahead[3], p];
        let g = &found.preview;
        let s = &found.state;
        let got = [found.integral, s[0], s[1], s[2], g[0], g[1], g[9], g[99], found.riccati.p[(1, 1)]];
        for (got, truth) in got.iter().zip(truth) {
            // SciPy's P misses the equation by 2e-14 and ours by less; the condition of some 1e4
            // makes this 1e-10.
            assert!((got - truth).abs() < 1e-8 * truth.abs(), "{got} {truth}");
        }
        // A constant zero-moment point has the centre of mass above it: the position gains cancel,
        // except for the part beyond the horizon, exp(-sqrt(g/h) horizon).
        let beyond = (-(9.81f64 / height).sqrt() * 320.0 * period).exp();
        let sum: f64 = s[0] + g.iter().sum::<f64>();
        assert!(sum.abs() < 10.0 * beyond * s[0] + 1e-9 * s[0], "{sum}");
    }
}

fn stride(length: f64) -> Stride {
    Stride { steps: 5, length, rise: 0.0, time: 0.8, double_support: 0.2, height: 0.02, wait: 1.0, first: 1 }
}

fn footsteps(length: f64) -> Footsteps {
    let soles = [Vector3::new(0.1, 0.04, 0.0), Vector3::new(0.1, -0.04, 0.0)];
    Footsteps::new(stride(length), soles, Vector3::x(), f64::INFINITY)
}

#[test]
fn feet_land_at_the_planned_positions_and_times() {
    let plan = footsteps(0.03);
    assert!((plan.duration() - (2.0 + 5.0 * 0.8 + 0.2)).abs() < 1e-12);
    // Footfalls 1, 3, 5 of the right foot, 2 and 4 of the left; the last is level with the other
    // foot.
    for (i, right, left) in
        [(0, 0.0, 0.0), (1, 0.03, 0.0), (2, 0.03, 0.06), (3, 0.09, 0.06), (4, 0.09, 0.12), (5, 0.12, 0.12)]
    {
        let t = 1.0 + 0.8 * f64::from(i);
        for (foot, y, x) in [(0, 0.04, left), (1, -0.04, right)] {
            let (place, velocity) = plan.sole(foot, t);
            assert!((place - Vector3::new(0.1 + x, y, 0.0)).norm() < 1e-12, "step {i} foot {foot}: {place}");
            assert!(velocity.norm() < 1e-12);
        }
    }
    // During a swing the landing is the foot's next position, otherwise its current one.
    for foot in [0, 1] {
        assert_eq!(plan.landing(foot, 0.5), plan.sole(foot, 0.5).0);
        for i in 0..5 {
            let (now, next) = (1.0 + 0.8 * f64::from(i) + 0.3, 1.0 + 0.8 * f64::from(i + 1));
            assert_eq!(plan.landing(foot, now), plan.sole(foot, next).0, "step {i} foot {foot}");
        }
        assert_eq!(plan.landing(foot, 6.0), plan.sole(foot, 6.0).0);
    }
    // Half way through the swing of step 2: 20 mm up, in the middle, at 15/8 of the mean speed.
    let (place, velocity) = plan.sole(0, 1.8 + 0.2 + 0.3);
    assert!((place - Vector3::new(0.13, 0.04, 0.02)).norm() < 1e-12, "{place}");
    assert!((velocity - Vector3::new(0.06 / 0.6 * 15.0 / 8.0, 0.0, 0.0)).norm() < 1e-12, "{velocity}");
    // Never two feet in the air, and velocities are derivatives of positions.
    let h = 1e-6;
    for k in 0..620 {
        let t = 0.0051 + f64::from(k) * 0.01;
        let places = [0, 1].map(|foot| plan.sole(foot, t));
        assert!(places.iter().filter(|p| p.0.z > 0.0).count() < 2);
        for (foot, (_, velocity)) in places.iter().enumerate() {
            let slope = (plan.sole(foot, t + h).0 - plan.sole(foot, t - h).0) / (2.0 * h);
            // h^2 / 6 times a third derivative of some 60 m/s^3, and 1e-16 / h of rounding.
            assert!((slope - velocity).norm() < 1e-8, "{t}");
        }
    }
}

/// On stairs feet land a rise above each other, the last two level, and the ground is that of the lower
/// foot at both ends of each step.
#[test]
fn feet_climb_stairs() {
    let soles = [Vector3::new(0.1, 0.04, 0.2), Vector3::new(0.1, -0.04, 0.2)];
    let plan = Footsteps::new(Stride { rise: -0.015, ..stride(0.03) }, soles, Vector3::x(), f64::INFINITY);
    let rises = [(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (3.0, 2.0), (3.0, 4.0), (4.0, 4.0)];
    for (i, (right, left)) in rises.into_iter().enumerate() {
        let t = 1.0 + 0.8 * i as f64;
        for (foot, rise) in [(0, left), (1, right)] {
            assert!((plan.sole(foot, t).0.z - (0.2 - 0.015 * rise)).abs() < 1e-15, "step {i} foot {foot}");
        }
        let [height, rate, acceleration] = plan.ground(t);
        assert!((height + 0.015 * f64::max(left, right)).abs() < 1e-15, "step {i}: {height}");
        assert!(rate.abs() < 1e-12 && acceleration.abs() < 1e-12);
    }
    // A fifth of the way across, at 0.35 of the swing, a foot on its way down is still at the upper height.
    let (foot, _) = plan.sole(1, 1.2 + 0.35 * 0.6);
    assert!(foot.z > 0.2 && (foot.x - 0.1 - 0.03 * 0.05792).abs() < 1e-6, "{foot}");
    let h = 1e-5;
    for k in 0..620 {
        let t = 0.0051 + f64::from(k) * 0.01;
        for foot in [0, 1] {
            let slope = (plan.sole(foot, t + h).0 - plan.sole(foot, t - h).0) / (2.0 * h);
            // h^2 / 6 times a third derivative of some 130 m/s^3.
            assert!((slope - plan.sole(foot, t).1).norm() < 1e-8, "{t}");
        }
        let ([before, slow, _], [_, rate, acceleration], [after, fast, _]) =
            (plan.ground(t - h), plan.ground(t), plan.ground(t + h));
        // h^2 / 6 times a third derivative of 60 R / 0.6^3, 4 m/s^3, and 1e-16 / h of rounding.
        assert!(((after - before) / (2.0 * h) - rate).abs() < 1e-9, "{t}");
        // A third derivative that jumps by 4 m/s^3 where swings begin and end, times h.
        assert!(((fast - slow) / (2.0 * h) - acceleration).abs() < 4e-5, "{t}");
    }
}

/// The beginning of a longer plan equals the shorter plan.
#[test]
fn a_shorter_plan_agrees_with_a_longer_one() {
    let soles = [Vector3::new(0.1, 0.04, 0.0), Vector3::new(0.1, -0.04, 0.0)];
    let long = |steps: usize, until: f64| Footsteps::new(Stride { steps, ..stride(0.03) }, soles, Vector3::x(), until);
    let (whole, part) = (long(40, f64::INFINITY), long(40, 7.3));
    assert_eq!(whole.duration(), part.duration());
    for k in 0..=730 {
        let t = 0.01 * f64::from(k);
        assert_eq!(
            (whole.sole(0, t), whole.sole(1, t), whole.zmp(t)),
            (part.sole(0, t), part.sole(1, t), part.zmp(t)),
            "{t}"
        );
    }
    // Limited by the duration, not by the number requested.
    let endless = long(usize::MAX, 7.3);
    assert_eq!(endless.sole(1, 5.0), whole.sole(1, 5.0));
    let preview = Preview::new(0.26, 9.81, 0.005, 1.6).unwrap();
    let reference =
        |until: f64| (0..(until / 0.005) as usize).map(|k| whole.zmp(k as f64 * 0.005).y).collect::<Vec<_>>();
    let (all, some) = (preview.follow(&reference(20.0), 4000), preview.follow(&reference(5.0 + 1.61), 1000));
    assert!(some.len() == 1000 && all[..1000] == some[..]);
}

#[test]
fn swings_land_without_speed_or_acceleration() {
    let plan = footsteps(0.03);
    let land = 1.8;
    // p = p1 + O(s^3): 5 ms before the end, of 0.6 s, the rest is (1/120)^3 (10 * 0.03 + 64 * 0.02)
    // m, 9e-7 m.
    let (place, velocity) = plan.sole(1, land - 0.005);
    let left = (place - plan.sole(1, land).0).norm();
    assert!(left < 1e-6 && velocity.norm() < 6e-4, "{left:e} {velocity}");
}

#[test]
fn the_zero_moment_point_is_under_the_stance_foot_and_is_followed() {
    let plan = footsteps(0.03);
    assert!((plan.zmp(0.5).y).abs() < 1e-12 && (plan.zmp(5.5) - plan.zmp(6.2)).norm() < 1e-12);
    for (i, side) in [(0, 0.04), (1, -0.04), (2, 0.04), (3, -0.04), (4, 0.04)] {
        // Right swings first, so the left foot is the first stance foot.
        let t = 1.0 + 0.8 * f64::from(i) + 0.5;
        let foot = usize::from(side < 0.0);
        assert!((plan.zmp(t) - plan.sole(foot, t).0.xy()).norm() < 1e-12, "step {i}");
    }
    let (period, height) = (0.005, 0.26);
    let preview = Preview::new(height, 9.81, period, 1.6).unwrap();
    let reference: Vec<f64> = (0..1240).map(|k| plan.zmp(f64::from(k) * period).y).collect();
    let samples = preview.follow(&reference, reference.len());
    let off = samples.iter().zip(&reference).map(|(s, r)| (preview.zmp(&s.x) - r).abs()).fold(0.0, f64::max);
    // The weight of the jerk leaves some 0.5 mm where the reference changes direction.
    assert!(off < 1e-3 && off > 0.0, "{off}");
    // In steady stepping the pendulum's closed form bounds the sway: less than the foot's 40 mm,
    // more than half of it.
    let sway = samples.iter().map(|s| s.x[0].abs()).fold(0.0, f64::max);
    assert!(sway > 0.02 && sway < 0.04, "{sway}");
    // The model itself: c'' = g/h (c - p), which `zmp` inverts, and consecutive samples agree.
    for pair in samples.windows(2) {
        assert!((pair[0].at(period) - pair[1].x).norm() < 1e-9);
    }
}

#[test]
fn a_centre_of_mass_at_rest_on_the_reference_stays() {
    let preview = Preview::new(0.26, 9.81, 0.005, 1.6).unwrap();
    let samples = preview.follow(&[0.123; 400], 400);
    assert!(samples.iter().all(|s| s.x == Vector3::new(0.123, 0.0, 0.0) && s.jerk == 0.0));
    assert!(preview.follow(&[], 0).is_empty());
    assert!(Preview::new(0.26, 0.0, 0.005, 1.6).is_none());
}
