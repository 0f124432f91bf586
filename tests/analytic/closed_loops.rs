//! Closed loops by closed forms: a four-bar linkage by its one degree of freedom, and an ankle with
//! parallel rods under load.

use super::body::G;
use crate::support::runs::{Recording, finish, rk4, simulation};
use nalgebra::Vector3;
use stiction::sim::NullObserver;

/// `robots/four-bar`: crank, distance of the pivots, rocker, and the coupler's far end in its frame.
const CRANK: f64 = 0.2;
const BASE: f64 = 0.4;
const ROCKER: f64 = 0.3;
const END: (f64, f64) = (0.4, 0.1);

/// Angles of the bars about y from the crank's: coupler and rocker, absolute. A bar at angle a has its
/// local (x, z) at `(x cos a + z sin a, z cos a - x sin a)`.
fn angles(crank: f64) -> (f64, f64) {
    let (px, pz) = (CRANK * crank.sin() - BASE, CRANK * crank.cos());
    let length = END.0.hypot(END.1);
    // The point at ROCKER from the origin and `length` from (px, pz), on the side of home.
    let (distance, towards) = (px.hypot(pz), pz.atan2(px));
    let cos = (ROCKER * ROCKER + distance * distance - length * length) / (2.0 * ROCKER * distance);
    let at = towards - cos.acos();
    let (x, z) = (ROCKER * at.cos(), ROCKER * at.sin());
    let rocker = x.atan2(z);
    // Direction of the coupler's end from the elbow.
    let coupler = (x - px).atan2(z - pz) - END.0.atan2(END.1);
    (coupler, rocker)
}

/// Inertia of the linkage, `T = i crank'^2 / 2`, and its potential energy.
fn energies(crank: f64) -> (f64, f64) {
    let at = |q: f64| {
        let (coupler, rocker) = angles(q);
        let elbow = (CRANK * q.sin(), CRANK * q.cos());
        let local = |x: f64, z: f64, a: f64| (x * a.cos() + z * a.sin(), z * a.cos() - x * a.sin());
        let c = local(0.2, 0.05, coupler);
        let of_coupler = (elbow.0 + c.0, elbow.1 + c.1);
        [coupler, rocker, of_coupler.0, of_coupler.1, 0.1 * q.cos(), 0.15 * rocker.cos()]
    };
    // Fourth-order difference: truncation and rounding are below 1e-12.
    let h = 1e-3;
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(crank + k * h));
    let rate = |i: usize| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h);
    let inertia = 0.002
        + 0.4 * 0.01
        + 0.8 * (rate(2).powi(2) + rate(3).powi(2))
        + 0.01 * rate(0).powi(2)
        + (0.004 + 0.6 * 0.15 * 0.15) * rate(1).powi(2);
    let now = at(crank);
    (inertia, G * (0.4 * now[4] + 0.8 * now[3] + 0.6 * now[5]))
}

/// `i q'' = -i' q'^2 / 2 - V'`
fn acceleration(q: f64, rate: f64) -> f64 {
    let h = 1e-3;
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| energies(q + k * h));
    let slope = |f: fn((f64, f64)) -> f64| (f(a) - 8.0 * f(b) + 8.0 * f(c) - f(d)) / (12.0 * h);
    -(0.5 * slope(|e| e.0) * rate * rate + slope(|e| e.1)) / energies(q).0
}

#[test]
fn a_four_bar_linkage_moves_as_its_one_degree_of_freedom() {
    let duration = 2.0;
    let mut sim = simulation(&format!(
        "duration = {duration}
        floor.plane = false
        integrator = {{ relative_tolerance = 1e-11, absolute_tolerance = 1e-12 }}
        log.rate = 100
        [robot]
        model = \"robots/four-bar/four-bar.toml\"
        joint_default = {{ mode = \"passive\" }}
        posture = {{ crank = 0.3 }}
        velocity = {{ crank = 6.0 }}\n"
    ));
    let mut recording = Recording::default();
    let metrics = finish(&mut sim, &mut recording);
    assert!(metrics.max_loop_error_m.is_some_and(|error| error < 1e-12), "{:?}", metrics.max_loop_error_m);
    // Integration error.
    assert!(metrics.max_energy_error_j < 1e-8, "{}", metrics.max_energy_error_j);
    let truth = rk4([0.3, 6.0], duration, 20_000, |_, s| [s[1], acceleration(s[0], s[1])]);
    let (q, v) = (&sim.plant().state.joints, &sim.plant().state.v);
    // Differences of the energies, and integration at 1e-11 over some thousand steps.
    assert!((q[0] - truth[0]).abs() < 1e-7 && (v[0] - truth[1]).abs() < 1e-6, "{} {} {truth:?}", q[0], v[0]);
    // Every logged posture is closed, with the loop's own error.
    let wrap = |a: f64| (a + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    for snapshot in &recording.snapshots {
        let (coupler, rocker) = angles(snapshot.q[0]);
        assert!(wrap(snapshot.q[0] + snapshot.q[1] - coupler).abs() < 1e-11, "at {}", snapshot.time);
        assert!(wrap(snapshot.q[2] - rocker).abs() < 1e-11, "at {}", snapshot.time);
        assert!(snapshot.loops[0].1 < 1e-12);
    }
    // The rocker's equation about its pivot gives the force of the hinge on it, the opposite of that on the
    // coupler: I a = m g s sin + moment of the force.
    for pair in recording.snapshots.windows(3).skip(1).step_by(20) {
        let [before, now, after] = pair else { unreachable!("windows of three") };
        let h = now.time - before.time;
        let turn = (after.qd[2] - before.qd[2]) / (2.0 * h);
        let arm = Vector3::new(ROCKER * now.q[2].sin(), 0.0, ROCKER * now.q[2].cos());
        let moment = arm.cross(&-now.loops[0].0[0]).y + 0.6 * G * 0.15 * now.q[2].sin();
        let inertia = 0.004 + 0.6 * 0.15 * 0.15;
        // The difference quotient over 0.01 s.
        assert!((inertia * turn - moment).abs() < 0.02 * (1.0 + moment.abs()), "{} {moment}", inertia * turn);
    }
}

/// Both rods stay parallel to the shank, so that the cranks together carry the moment of the weight above
/// the ankle.
#[test]
fn parallel_rods_transmit_the_moment_of_the_ankle() {
    for contact in ["", "contact.method = \"one-step\"\nintegrator = { method = \"semi-implicit\", step = 1e-3 }"] {
        let text = format!(
            "duration = 3.0
            log.rate = 0
            {contact}
            robot.model = \"robots/ankle/ankle.toml\"
            robot.joint = {{ pitch = {{ friction = {{ coulomb = 0.0, viscous = 1.0 }} }} }}\n"
        );
        let mut sim = simulation(&text);
        let metrics = finish(&mut sim, &mut NullObserver);
        assert!(metrics.max_loop_error_m.is_some_and(|error| error < 1e-12), "{:?}", metrics.max_loop_error_m);
        let plant = sim.plant();
        let joint = |name: &str| plant.model.joint(name).expect("a joint").0;
        let effort = |name: &str| plant.drives.efforts[joint(name)];
        // Moment of the weights about the ankle, those of the cranks at their pivots: the drives carry the rest.
        let ankle = plant.state.position;
        let mut moment = 0.0;
        for (link, body) in plant.model.links.iter().zip(&plant.ws.links) {
            if link.name == "shank" || link.name.ends_with("_crank") {
                let own = if link.name == "shank" { body.rotation * link.com } else { Vector3::zeros() };
                let com = plant.state.position + body.origin + own;
                moment += link.mass * G * (com.x - ankle.x);
            }
        }
        let cranks = effort("left_crank") + effort("right_crank");
        // Servo and damping have settled.
        assert!(moment > 0.9 && (cranks - moment).abs() < 1e-6, "{cranks} {moment}");
        assert!(plant.state.joints[joint("roll")].abs() < 1e-12);
    }
}

/// A start that the loop does not permit is refused, and one that it does is completed.
#[test]
fn starts_are_closed_or_refused() {
    let start = |posture: &str| {
        format!(
            "floor.plane = false\nrobot = {{ model = \"robots/four-bar/four-bar.toml\", posture = {{ {posture} }} }}\n"
        )
    };
    for crank in [-1.5, 0.0, 0.3, 1.2] {
        let sim = simulation(&start(&format!("crank = {crank}")));
        let q = &sim.plant().state.joints;
        let (coupler, rocker) = angles(crank);
        assert_eq!(q[0], crank);
        assert!((q[0] + q[1] - coupler).abs() < 1e-12 && (q[2] - rocker).abs() < 1e-12, "{crank}: {q:?}");
    }
}
