//! Breakaway loads at any heading. A growing push at the height of the floor slips the block at
//! `mu_s m g`, a growing yaw moment at `mu_s m g r`, and both together at the exact capacity of the
//! sole.

use super::body::{Body, G};
use crate::support::runs::{TIGHT, run, watch};

/// Ramps force and moment from zero to full over a second at the sole's centre; returns the fraction at which it slips.
fn slip(body: &Body, yaw: f64, mu: [f64; 2], force: [f64; 3], moment: [f64; 3]) -> f64 {
    let text = format!(
        "duration = 1.0\nfloor = {{ friction = {{ static = {}, kinetic = {} }} }}\n{}{TIGHT}
        [[force]]
        type = \"push\"
        link = \"block\"
        point = [0.0, 0.0, {}]
        force = {force:?}
        moment = {moment:?}
        duration = 1.0
        profile = \"ramp\"\n",
        mu[0],
        mu[1],
        body.robot(&format!("rpy = [0.0, 0.0, {yaw}]")),
        -body.half[2]
    );
    let (m, recording) = watch(&text);
    assert_eq!((m.inconsistent, m.jams, m.impacts), (0, 0, 0));
    assert_eq!(recording.events.first().map(|e| e.kind.as_str()), Some("slip"));
    assert!(m.max_static_creep_m < 1e-12, "not a hair before");
    m.first_slip_s.expect("it slips")
}

// Each slip is an event located to 1e-13 of a step; the margin's Newton solve is good to 1e-12.
const LOCATED: f64 = 1e-9;

#[test]
fn a_push_slips_at_mu_m_g_for_every_heading() {
    for (body, mu) in Body::several().into_iter().zip([[0.5, 0.5], [0.8, 0.4], [0.05, 0.01], [0.3, 0.29]]) {
        for k in 0..10 {
            let heading = 0.1 + k as f64 * std::f64::consts::TAU / 10.0;
            let (full, yaw) = (1.3 * mu[0] * body.mass * G, 0.37 * k as f64);
            let at = slip(&body, yaw, mu, [full * heading.cos(), full * heading.sin(), 0.0], [0.0; 3]);
            assert!((at * 1.3 - 1.0).abs() < LOCATED, "{heading} {}", at * 1.3 - 1.0);
        }
    }
}

#[test]
fn a_yaw_moment_slips_at_mu_m_g_r() {
    for (body, mu) in Body::several().into_iter().zip([[0.5, 0.5], [0.8, 0.4], [0.05, 0.01], [0.3, 0.29]]) {
        for turn in [1.0, -1.0] {
            // Corners at equal distance r carry equal loads, so the capacity is mu m g r for the
            // oblong body too.
            let full = 1.7 * mu[0] * body.mass * G * body.radius();
            let at = slip(&body, 0.6, mu, [0.0; 3], [0.0, 0.0, turn * full]);
            assert!((at * 1.7 - 1.0).abs() < LOCATED, "{}", at * 1.7 - 1.0);
        }
    }
}

#[test]
fn push_and_moment_together_slip_on_the_capacity_found_by_scanning_slip_centres() {
    let mu = [0.4, 0.3];
    for body in [Body::new([0.1, 0.1, 0.05], 1.0), Body::new([0.12, 0.06, 0.03], 2.5)] {
        for (heading, share) in [(0.3, 0.6), (1.1, 0.3), (2.9, 0.9), (4.0, 1.2)] {
            let weight = mu[0] * body.mass * G;
            let (fx, fy) = (weight * f64::cos(heading), weight * f64::sin(heading));
            let moment = share * weight * body.radius();
            // Least load factor over all slip twists: power of friction over power of the load.
            let ratio = |vx: f64, vy: f64, w: f64| {
                let friction: f64 =
                    body.corners().iter().map(|[x, y]| 0.25 * weight * (vx - w * y).hypot(vy + w * x)).sum();
                let load = fx * vx + fy * vy + moment * w;
                if load > 0.0 { friction / load } else { f64::INFINITY }
            };
            let truth = least(|[a, b]| {
                // Direction on a sphere, with the rotation in units of the radius.
                let (sa, ca) = f64::sin_cos(a);
                let (sb, cb) = f64::sin_cos(b);
                ratio(ca * cb, sa * cb, sb / body.radius())
            });
            let at = slip(&body, 0.0, mu, [2.0 * fx, 2.0 * fy, 0.0], [0.0, 0.0, 2.0 * moment]);
            // The scan ends at a pattern size of 1e-9; the ratio is stationary there, or first
            // order at kinks.
            assert!((at * 2.0 / truth - 1.0).abs() < 2e-8, "{heading} {share}: {} {truth}", at * 2.0);
        }
    }
}

/// Minimum over two angles: a grid, then a pattern search from its best point.
fn least(f: impl Fn([f64; 2]) -> f64) -> f64 {
    let mut at = [0.0; 2];
    let mut best = f64::INFINITY;
    for i in 0..400 {
        for j in -100..=100 {
            let p = [i as f64 * std::f64::consts::TAU / 400.0, j as f64 * std::f64::consts::PI / 200.0];
            if f(p) < best {
                (best, at) = (f(p), p);
            }
        }
    }
    let mut size = 0.02;
    while size > 1e-9 {
        let around = (0..16).map(|k| {
            let (s, c) = (k as f64 * std::f64::consts::TAU / 16.0).sin_cos();
            [at[0] + size * c, at[1] + size * s]
        });
        match around.map(|p| (f(p), p)).min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(value, _)| *value < best) {
            Some((value, p)) => (best, at) = (value, p),
            None => size *= 0.7,
        }
    }
    best
}

/// The legs spread on ice. The load rises slowly to the friction limit, so slip begins at rest with
/// a tiny acceleration. Rounding then moves some vertices backwards at first. The selection must
/// not run again for them, because it would return them to rest at every step.
#[test]
fn feet_that_begin_to_slip_slowly_keep_slipping() {
    let slides = |tolerance: &str| {
        run(&format!(
            "duration = 1.6\nfloor = {{ friction = 0.1 }}\nintegrator = {{ {tolerance} }}
            [robot]\nmodel = \"robots/hoap2/hoap2.toml\"
            [[task]]\ntype = \"posture\"\nstart = 0.5\nduration = 1.0
            joints = {{ left_hip_roll = \"1 deg\", left_ankle_roll = \"-1 deg\", right_hip_roll = \"-1 deg\", right_ankle_roll = \"1 deg\" }}"
        ))
    };
    let (usual, fine) = (slides(""), slides("relative_tolerance = 1e-9, absolute_tolerance = 1e-11"));
    for m in [&usual, &fine] {
        // Both feet begin to slip and stick again.
        assert_eq!((m.state_changes, m.inconsistent), (4, 0));
        assert!(m.events <= 6, "{} events", m.events);
    }
    // With the usual tolerances, slower than 1e-7 m/s is rest, and the feet decelerate by some 1e-3
    // m/s^2.
    let ends = [usual.first_stick_s.expect("they stick"), fine.first_stick_s.expect("they stick")];
    assert!((ends[0] - ends[1]).abs() < 2e-4, "{ends:?}");
}
