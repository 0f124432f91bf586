//! `spring`: a box on a spring against the solutions of the linear oscillator.

use super::{End, G, fly};
use crate::analytic::body::Body;
use crate::support::runs::{Recording, finish, rk4, simulation};
use nalgebra::Vector3;
use stiction::sim::NullObserver;

const K: f64 = 50.0;
const HANG: [f64; 3] = [0.1, -0.2, 1.0];

fn body() -> Body {
    Body::new([0.1, 0.1, 0.05], 2.0)
}

/// Without gravity.
fn floating(text: &str) -> String {
    format!("gravity = [0, 0, 0]\n{text}")
}

fn spring(rest: &str) -> String {
    format!("[[force]]\ntype = \"spring\"\nlink = \"block\"\nstiffness = {K}\n{rest}\n")
}

/// The oscillator x'' + 2 b x' + w^2 (x - c) = 0 from x, x' at time 0: state after `t`,
/// underdamped.
fn oscillator(w2: f64, b: f64, centre: f64, x: f64, v: f64, t: f64) -> [f64; 2] {
    let w = (w2 - b * b).sqrt();
    let (p, q) = (x - centre, (v + b * (x - centre)) / w);
    let (sin, cos) = (w * t).sin_cos();
    let fade = (-b * t).exp();
    [centre + fade * (p * cos + q * sin), fade * ((q * w - b * p) * cos - (p * w + b * q) * sin)]
}

#[track_caller]
fn near(end: &End, position: Vector3<f64>, velocity: Vector3<f64>, allowed: f64) {
    let (x, v) = ((end.position - position).norm(), (end.velocity - velocity).norm());
    assert!(x < allowed && v < 10.0 * allowed, "off by {x} m, {v} m/s: {} {}", end.position, end.velocity);
}

#[test]
fn a_hanging_box_follows_its_closed_form() {
    let body = body();
    let (start, speed) = ([0.3, -0.2, 1.1], [0.0, 1.5, -0.5]);
    for (damping, duration) in [(0.0, 3.0), (4.0, 2.0)] {
        let text = spring(&format!("damping = {damping}\nanchor = {{ position = {HANG:?} }}"));
        let end = fly(&body, start, speed, duration, &text);
        let (w2, b) = (K / body.mass, 0.5 * damping / body.mass);
        let sag = [0.0, 0.0, -G / w2];
        let truth: [[f64; 2]; 3] =
            std::array::from_fn(|i| oscillator(w2, b, HANG[i] + sag[i], start[i], speed[i], duration));
        // Integration at relative tolerance 1e-9 over some 300 steps.
        near(&end, truth.map(|s| s[0]).into(), truth.map(|s| s[1]).into(), 1e-7);
        // The spring's work is external work: together with the box's own energy it closes the
        // energy balance.
        assert!(end.metrics.max_energy_error_j < 1e-8, "{:?}", end.metrics);
        let stretch = |p: Vector3<f64>| 0.5 * K * (p - Vector3::from(HANG)).norm_squared();
        let elastic_work = stretch(start.into()) - stretch(end.position);
        if damping == 0.0 {
            assert!(
                (end.metrics.external_work_j - elastic_work).abs() < 1e-7,
                "{} {elastic_work}",
                end.metrics.external_work_j
            );
        } else {
            assert!(end.metrics.external_work_j < elastic_work - 0.1, "the damper takes something");
        }
    }
}

#[test]
fn a_moving_anchor_pulls_a_box_along() {
    // The box starts at rest at the hand's grip, without gravity: x = u t - u sin(w t) / w after
    // the start.
    let body = body();
    let (hand, held, start) = ([0.4, -0.1, 0.2], 1.2, 0.5);
    let w = (K / body.mass).sqrt();
    let text = spring(&format!("start = {start}\nduration = {held}\nanchor = {{ velocity = {hand:?} }}"));
    let place = Vector3::new(1.0, 2.0, 3.0);
    // The box drifts until the hand grips it, and is released after `held`.
    let drift = Vector3::new(0.0, 0.05, 0.0);
    let end = fly(&body, place.into(), drift.into(), start + held + 0.3, &floating(&text));
    let grip = place + drift * start;
    let hand = Vector3::from(hand);
    let (sin, cos) = (w * held).sin_cos();
    let swing = (drift - hand) / w;
    let at_release = grip + hand * held + swing * sin;
    let velocity = hand + swing * (w * cos);
    near(&end, at_release + velocity * 0.3, velocity, 1e-7);
}

#[test]
fn an_oscillating_hand_drives_the_forced_oscillation() {
    let body = body();
    let (a, f, phase, c) = ([0.05, 0.0, 0.1], 1.3, 0.7, 3.0);
    let text = spring(&format!(
        "damping = {c}\nanchor = {{ position = {HANG:?}, sine = {{ amplitude = {a:?}, frequency = {f}, phase = {phase} }} }}"
    ));
    let end = fly(&body, HANG, [0.0; 3], 2.0, &text);
    let rate = std::f64::consts::TAU * f;
    let truth: [[f64; 2]; 3] = std::array::from_fn(|i| {
        let g = if i == 2 { -G } else { 0.0 };
        let hand = |t: f64| (HANG[i] + a[i] * (rate * t + phase).sin(), a[i] * rate * (rate * t + phase).cos());
        rk4([HANG[i], 0.0], 2.0, 20_000, |t, s| {
            let (p, v) = hand(t);
            [s[1], (K * (p - s[0]) + c * (v - s[1])) / body.mass + g]
        })
    });
    near(&end, truth.map(|s| s[0]).into(), truth.map(|s| s[1]).into(), 1e-7);
}

#[test]
fn a_hand_follows_waypoints() {
    let body = body();
    for (path, smooth) in [("minimum-jerk", true), ("linear", false)] {
        let text = spring(&format!(
            "damping = 2.0\nanchor = {{ path = \"{path}\", waypoints = [{{ at = 0.2, position = [0, 0, 1] }}, \
             {{ at = 0.7, position = [0.3, 0, 1] }}, {{ at = 1.0, position = [0.1, 0, 1] }}] }}"
        ));
        let end = fly(&body, [0.0, 0.0, 1.0], [0.0; 3], 1.5, &floating(&text));
        let hand = |t: f64| {
            let (from, to, a, b) = match t {
                _ if t < 0.2 => return (0.0, 0.0),
                _ if t < 0.7 => (0.2, 0.7, 0.0, 0.3),
                _ if t < 1.0 => (0.7, 1.0, 0.3, 0.1),
                _ => return (0.1, 0.0),
            };
            let s = (t - from) / (to - from);
            let (m, rate) = if smooth {
                (s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * (s * (1.0 - s)).powi(2))
            } else {
                (s, 1.0)
            };
            (a + (b - a) * m, (b - a) * rate / (to - from))
        };
        let truth = rk4([0.0, 0.0], 1.5, 150_000, |t, s| {
            let (p, v) = hand(t);
            [s[1], (K * (p - s[0]) + 2.0 * (v - s[1])) / body.mass]
        });
        // The quadrature does not stop at the corners of the linear path: jumps of 25 m/s^2 over
        // steps of 1e-5 s.
        near(&end, Vector3::new(truth[0], 0.0, 1.0), Vector3::new(truth[1], 0.0, 0.0), 1e-6);
    }
}

#[test]
fn a_spring_with_rest_length_moves_on_a_circle() {
    // m w^2 r = k (r - l0), at speed w r across.
    let body = body();
    let (rest, r) = (0.3_f64, 0.5_f64);
    let w = (K * (r - rest) / (body.mass * r)).sqrt();
    let text = spring(&format!("rest_length = {rest}\nanchor = {{ position = [0, 0, 1] }}"));
    let turn = 0.8 * std::f64::consts::TAU;
    let end = fly(&body, [r, 0.0, 1.0], [0.0, w * r, 0.0], turn / w, &floating(&text));
    let (sin, cos) = turn.sin_cos();
    near(&end, Vector3::new(r * cos, r * sin, 1.0), Vector3::new(-w * r * sin, w * r * cos, 0.0), 1e-7);
    // A spring shorter than its rest length pushes: after half a period it is too long by the
    // initial difference.
    let half = std::f64::consts::PI / (K / body.mass).sqrt();
    let end = fly(&body, [0.2, 0.0, 1.0], [0.0; 3], half, &floating(&text));
    near(&end, Vector3::new(0.4, 0.0, 1.0), Vector3::zeros(), 1e-7);
}

#[test]
fn an_off_centre_spring_conserves_energy_and_rotates_the_box() {
    let body = body();
    let text = spring("point = [0.1, 0.05, 0.0]\nanchor = { position = [0.1, -0.2, 1.0] }");
    let end = fly(&body, [0.3, 0.0, 1.2], [0.5, 0.0, 0.0], 2.0, &text);
    // Integration at relative tolerance 1e-9 of some 10 J.
    assert!(end.metrics.max_energy_error_j < 1e-7, "{:?}", end.metrics.max_energy_error_j);
    let spin = end.metrics.final_base_angular_velocity.iter().map(|x| x.abs()).fold(0.0, f64::max);
    assert!(spin > 0.5, "it turns: {:?}", end.metrics.final_base_angular_velocity);
}

#[test]
fn attaching_and_releasing_are_events() {
    let body = body();
    let text = spring("start = 0.25\nduration = 0.5");
    let robot = body.floating("position = [0, 0, 2]");
    let mut recorded = Recording::default();
    finish(&mut simulation(&format!("duration = 1.0\n{robot}{text}")), &mut recorded);
    let messages: Vec<_> = recorded.events.iter().filter(|e| e.kind == "spring").collect();
    assert_eq!(
        messages.iter().map(|e| (e.time, e.subject.as_str())).collect::<Vec<_>>(),
        [(0.25, "block"), (0.75, "block")]
    );
    // Position reached in free fall: 2 - g 0.25^2 / 2.
    assert_eq!(messages[0].message, "attached to (0.0000, 0.0000, 1.6934)");
    assert_eq!(messages[1].message, "released");
}

#[test]
fn a_stiff_damper_does_not_limit_implicit_steps() {
    // Rates of 1e5 and 5 1/s; the anchor moves along x from t = 0.
    let (k, c, body) = (1e6, 2e5, body());
    let scenario = |integrator: &str, point: &str, duration: f64| {
        let robot = body.floating("position = [0.1, 0.2, -0.1]");
        format!(
            "duration = {duration}\ngravity = [0, 0, 0]\nlog.rate = 0\n{robot}[integrator]\n{integrator}\n\
             [[force]]\ntype = \"spring\"\nlink = \"block\"\npoint = {point}\nstiffness = {k}\ndamping = {c}\n\
             anchor = {{ position = [0, 0, 0] }}\n"
        )
    };
    let end = |text: &str| {
        let mut sim = simulation(text);
        let m = finish(&mut sim, &mut NullObserver);
        let state = &sim.plant().state;
        (state.position, state.rotation, state.v.clone(), m)
    };
    let implicit = "method = \"rosenbrock\"";
    let (found, _, _, m) = end(&scenario(implicit, "[0, 0, 0]", 1.0));
    // x'' = -(c x' + k x) / m from rest.
    let (a, root) = (c / body.mass, (c * c / (body.mass * body.mass) - 4.0 * k / body.mass).sqrt());
    let (slow, fast) = (2.0 * k / body.mass / (a + root), 0.5 * (a + root));
    let share = (fast * (-slow).exp() - slow * (-fast).exp()) / (fast - slow);
    let truth = Vector3::new(0.1, 0.2, -0.1) * share;
    // Tolerance 1e-6 relative.
    assert!((found - truth).norm() < 1e-6, "{found} {truth}");
    // Explicit steps of at most 3.3e-5 s would be 30 000.
    assert!(m.steps < 1000 && m.max_energy_error_j < 1e-3 * k * 0.03, "{m:?}");
    // At a corner, where it turns the body by up to 10 rad/s.
    let ends = |integrator: &str| end(&scenario(integrator, "[0.1, 0.05, -0.03]", 0.05));
    let (truth, turned, v, explicit) = ends("relative_tolerance = 1e-10\nabsolute_tolerance = 1e-12");
    for tolerance in [1e-6, 1e-8] {
        let keys = format!("{implicit}\nrelative_tolerance = {tolerance}\nabsolute_tolerance = {}", 0.01 * tolerance);
        let (found, rotation, found_v, m) = ends(&keys);
        let speed = found_v.iter().zip(&v).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let off = [(found - truth).norm(), rotation.angle_to(&turned), speed];
        // Errors of some 100 steps add up.
        assert!(off.iter().all(|x| *x < 100.0 * tolerance), "{off:?}");
        assert!(2 * m.steps < explicit.steps, "{} {}", m.steps, explicit.steps);
    }
}
