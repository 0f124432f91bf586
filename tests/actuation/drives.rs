//! Velocity drives, effort and speed limits, and end stops, on a wheel.

use super::{NO_COMMANDS, link, robot, simulation, wheel};
use crate::support::runs::{Recording, finish};

const INERTIA: f64 = 0.2;

/// Error control at 1e-10; kinks (clipping, the edge of the band) are within a step of that error.
const EXPLICIT: [(&str, f64); 2] = [
    ("integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }", 1e-8),
    ("integrator = { method = \"bs23\", relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }", 1e-7),
];

fn driven(settings: &str, joint: &str, start: f64) -> String {
    format!(
        "duration = 0.5
        gravity = [0, 0, 0]
        log = {{ rate = 200.0 }}
        {settings}
        [robot]
        model = \"given\"
        soles = []
        joint = {{ axle = {{ {joint} }} }}
        velocity = {{ axle = {start} }}\n"
    )
}

/// Runs the wheel under constant commands and compares its speed with a closed form.
fn compare(joint: &str, start: f64, command: [f64; 3], truth: impl Fn(f64) -> f64) {
    for (settings, tolerance) in EXPLICIT {
        let text = driven(settings, joint, start);
        let mut sim = simulation(Some(&wheel(INERTIA)), &text, Some(move |_, _| command));
        let mut seen = Recording::default();
        let metrics = finish(&mut sim, &mut seen);
        for s in &seen.snapshots {
            assert!((s.qd[0] - truth(s.time)).abs() < tolerance, "{joint} {}: {} {}", s.time, s.qd[0], truth(s.time));
        }
        assert!(metrics.max_energy_error_j < tolerance, "{metrics:?}");
        // The logged command is not changed.
        let last = seen.snapshots.last().expect("one");
        assert_eq!((last.q_desired[0], last.qd_desired[0]), (command[0], command[1]));
    }
}

#[test]
fn a_velocity_drive_approaches_its_speed_exponentially() {
    let (v, kd, ff) = (2.0, 1.5, 0.3);
    let end = v + ff / kd;
    compare(&format!("mode = \"velocity\", kd = {kd}"), 0.0, [9.0, v, ff], |t| end * (1.0 - (-kd * t / INERTIA).exp()));
    // Implicit Euler: each step divides the remaining error by 1 + kd dt / I.
    let text = driven(
        "integrator = { method = \"semi-implicit\", step = 5e-3 }",
        &format!("mode = \"velocity\", kd = {kd}"),
        0.0,
    );
    let mut sim =
        simulation(Some(&wheel(INERTIA)), &(text + "[control]\nrate = 200.0\n"), Some(move |_, _| [9.0, v, ff]));
    let mut recording = Recording::default();
    let metrics = finish(&mut sim, &mut recording);
    let expected = end * (1.0 - (1.0 + kd * 5e-3 / INERTIA).powi(-100));
    assert!((sim.plant().state.v[0] - expected).abs() < 1e-12, "{} {expected}", sim.plant().state.v[0]);
    assert!(metrics.max_energy_error_j < 1e-13, "{metrics:?}");
}

#[test]
fn acceleration_is_constant_while_the_effort_limit_is_active() {
    // kd (v - qd) = 2 - qd falls below 1 at 0.2 s.
    let truth = |t: f64| if t < 0.2 { t / INERTIA } else { 2.0 - (-(t - 0.2) / INERTIA).exp() };
    compare("mode = \"velocity\", kd = 1.0, effort = 1.0", 0.0, [0.0, 2.0, 0.0], truth);
}

/// Speed limit of these drives.
const SPEED_LIMIT: f64 = 3.0;

#[test]
fn a_drive_does_not_accelerate_beyond_its_speed_limit() {
    // Full effort up to 0.9 of the limit, then a first-order approach with the time constant I b v
    // / F.
    let force = 2.0;
    let (border, rate) = (0.9 * SPEED_LIMIT * INERTIA / force, force / (INERTIA * 0.1 * SPEED_LIMIT));
    let truth = |t: f64| {
        if t < border { force * t / INERTIA } else { SPEED_LIMIT - 0.1 * SPEED_LIMIT * (-rate * (t - border)).exp() }
    };
    compare(&format!("mode = \"force\", velocity = {SPEED_LIMIT}"), 0.0, [0.0, 0.0, force], truth);
    compare(&format!("mode = \"force\", velocity = {SPEED_LIMIT}"), -0.0, [0.0, 0.0, -force], |t| -truth(t));
}

#[test]
fn beyond_its_speed_limit_a_drive_only_brakes() {
    let joint = format!("mode = \"force\", velocity = {SPEED_LIMIT}");
    compare(&joint, 4.0, [0.0, 0.0, 2.0], |_| 4.0);
    compare(&joint, 4.0, [0.0, 0.0, -2.0], |t| 4.0 - 2.0 * t / INERTIA);
    compare("mode = \"force\", velocity = 0.0", 1.0, [0.0, 0.0, -2.0], |_| 1.0);
}

#[test]
fn velocity_level_steps_do_not_overshoot_the_speed_limit() {
    // 50 N m on 0.01 kg m^2 would gain 5 rad/s in a step.
    for drive in ["mode = \"force\"", "mode = \"position\", kp = 500.0, kd = 1.0, effort = 50.0"] {
        let text = driven(
            "integrator = { method = \"semi-implicit\", step = 1e-3 }",
            &format!("{drive}, velocity = {SPEED_LIMIT}"),
            0.0,
        );
        let mut sim = simulation(Some(&wheel(0.01)), &text, Some(|_, _| [50.0, 0.0, 50.0]));
        let mut recording = Recording::default();
        let metrics = finish(&mut sim, &mut recording);
        let fastest = recording.snapshots.iter().map(|s| s.qd[0]).fold(0.0, f64::max);
        // The approach divides the remaining error by 1 + F dt / (I b v) = 17.7 per step: zero up
        // to rounding.
        assert!(fastest <= SPEED_LIMIT + 1e-12 && sim.plant().state.v[0] > SPEED_LIMIT - 1e-9, "{drive}: {fastest}");
        // The work of the drive equals the energy of the wheel.
        let energy = 0.5 * 0.01 * sim.plant().state.v[0].powi(2);
        assert!((metrics.actuator_work_j - energy).abs() < 1e-12, "{metrics:?}");
    }
}

/// The wheel with limits at +-0.5 rad.
fn stopped(inertia: f64) -> String {
    robot(&[
        "<link name=\"world\"/>".into(),
        "<joint name=\"axle\" type=\"revolute\"><parent link=\"world\"/><child link=\"wheel\"/><axis xyz=\"0 0 1\"/>
        <limit lower=\"-0.5\" upper=\"0.5\" effort=\"9\" velocity=\"99\"/></joint>"
            .into(),
        link("wheel", 1.0, 0.0, inertia),
    ])
}

#[test]
fn an_undamped_stop_returns_the_energy_and_the_default_stop_dissipates_most() {
    let tight = "integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }";
    let (v, k) = (2.0, 80.0);
    // The way to the spring, half a period of it, and back past the middle.
    let text = driven(tight, &format!("mode = \"passive\", stop = {{ stiffness = {k} }}"), v);
    let mut sim = simulation(Some(&stopped(INERTIA)), &text, NO_COMMANDS);
    let mut recording = Recording::default();
    let metrics = finish(&mut sim, &mut recording);
    let half_swing = std::f64::consts::PI * (INERTIA / k).sqrt();
    let state = &sim.plant().state;
    // The spring begins within a step; error control at 1e-10 resolves it.
    assert!((state.v[0] + v).abs() < 1e-8, "{}", state.v[0]);
    assert!((state.joints[0] - (0.5 - v * (0.25 - half_swing))).abs() < 1e-8, "{}", state.joints[0]);
    assert!(metrics.joint_loss_j.abs() < 1e-8, "{metrics:?}");

    // Critically damped; contact ends when the damper would pull: p = v t e^(-wt) until w t = 2, at
    // -v e^-2.
    let mut sim = simulation(Some(&stopped(INERTIA)), &driven(tight, "mode = \"passive\"", -v), NO_COMMANDS);
    let mut recording = Recording::default();
    finish(&mut sim, &mut recording);
    let back = v * (-2f64).exp();
    let state = &sim.plant().state;
    assert!((state.v[0] - back).abs() < 1e-7, "{} {back}", state.v[0]);

    // Steps of 2e-2 s, four times the stability limit of an explicit damper of 600/s.
    let text = driven("integrator = { method = \"semi-implicit\", step = 2e-2 }", "mode = \"passive\"", v);
    let mut sim = simulation(Some(&stopped(INERTIA)), &text, NO_COMMANDS);
    let mut recording = Recording::default();
    let metrics = finish(&mut sim, &mut recording);
    assert!(recording.snapshots.iter().all(|s| s.q[0] < 0.5 + v * 2e-2 && s.qd[0].abs() <= v), "{metrics:?}");
    assert!(metrics.joint_loss_j > 0.5 * 0.5 * INERTIA * v * v, "{metrics:?}");
}

/// A load of 100 N m acts for 2 ms on a rotor of 0.01 kg m^2 with a stiff servo. The servo may
/// exert 1 N m: this leaves w = 10 - 0.05 rad/s at 50 ms, however high its gains.
#[test]
fn a_velocity_level_step_obeys_the_effort_limit() {
    let rotor = wheel(0.01);
    for gains in ["kp = 100.0, kd = 5.0", "kp = 1e5, kd = 0.0", "kp = 1e5, kd = 5.0, lag = 1e-9"] {
        let text = format!(
            "duration = 0.1\ngravity = [0, 0, 0]\nintegrator = {{ method = \"semi-implicit\", step = 1e-3 }}\nlog = {{ rate = 1000 }}
            [robot]\nmodel = \"rotor.urdf\"\nsoles = []
            joint = {{ axle = {{ {gains}, effort = 1.0 }} }}
            [[force]]\ntype = \"push\"\nlink = \"wheel\"\nforce = [0, 0, 0]\nmoment = [0, 0, 100]\nstart = 0.0\nduration = 0.002"
        );
        let mut sim = simulation(Some(&rotor), &text, NO_COMMANDS);
        let mut recording = Recording::default();
        finish(&mut sim, &mut recording);
        let at = |t: f64| recording.snapshots.iter().find(|s| (s.time - t).abs() < 1e-9).expect("it is logged");
        // The servo is at its limit from the first step on; at zero error it exerts nothing, for
        // one step at most.
        let expected = (100.0 * 0.002 - 0.05) / 0.01;
        assert!((at(0.05).qd[0] - expected).abs() < 0.1 + 1e-9, "{gains}: {}", at(0.05).qd[0]);
        for s in &recording.snapshots {
            assert!(s.effort[0].abs() <= 1.0 + 1e-12, "{gains}: {} at {}", s.effort[0], s.time);
        }
        // The logged effort is the effort that acted.
        for (a, b) in recording.snapshots.iter().zip(&recording.snapshots[1..]).filter(|(a, _)| a.time > 0.0025) {
            let acted = 0.01 * (b.qd[0] - a.qd[0]) / (b.time - a.time);
            assert!(
                (acted - b.effort[0]).abs() < 1e-9,
                "{gains}: {acted} but {} in the log at {}",
                b.effort[0],
                b.time
            );
        }
    }
}
