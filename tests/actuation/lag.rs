//! Actuators with a first-order lag, against closed forms.

use super::{NO_COMMANDS, hinge, link, robot, simulation, wheel};
use crate::support::runs::{Recording, finish, rk4};
use stiction::sim::NullObserver;

/// A wheel of 0.2 kg m^2 whose actuator has a time constant of 0.03 s.
const INERTIA: f64 = 0.2;
const T: f64 = 0.03;

fn driven(settings: &str, drive: &str, duration: f64) -> String {
    format!(
        "duration = {duration}
        gravity = [0, 0, 0]
        log = {{ rate = 200.0 }}
        {settings}
        [robot]
        model = \"given\"
        soles = []
        joint = {{ axle = {{ {drive}, lag = {T} }} }}\n"
    )
}

const EXPLICIT: [(&str, f64); 3] = [
    // Error control at 1e-10 over the run, and fixed steps of 1e-3 = T / 30 at order 4: (1/30)^5 / 120 of each step.
    ("integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }", 1e-9),
    ("integrator = { method = \"bs23\", relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }", 1e-7),
    ("integrator = { method = \"rk4\", step = 1e-3 }", 1e-8),
];

#[test]
fn a_step_command_gives_an_exponential_response() {
    // u = 2 N m from the tick at 0.1 s on.
    let commanded_effort = |_: usize, t: f64| [0.0, 0.0, if t < 0.1 - 1e-9 { 0.0 } else { 2.0 }];
    let semi = ("integrator = { method = \"semi-implicit\", step = 1e-3 }", 1e-12);
    for (settings, tolerance) in EXPLICIT.into_iter().chain([semi]) {
        let text = driven(settings, "mode = \"force\"", 0.4);
        let mut sim = simulation(Some(&wheel(INERTIA)), &text, Some(commanded_effort));
        let mut recording = Recording::default();
        let metrics = finish(&mut sim, &mut recording);
        let snapshots = recording.snapshots.iter();
        let mut rows: Vec<_> = snapshots.map(|s| (s.time, s.effort[0], s.qd[0])).collect();
        if settings == semi.0 {
            // A fixed step logs the effort at its start, so only the end is compared.
            let state = &sim.plant().state;
            rows = vec![(state.time, state.actuators[0], state.v[0])];
        }
        for (time, found, rate) in rows {
            let t = (time - 0.1f64).max(0.0);
            let effort = 2.0 * (1.0 - (-t / T).exp());
            // I qd = 2 (t - T (1 - e^(-t/T))); velocity-level steps take the exact mean of the effort.
            let speed = (2.0 * t - T * effort) / INERTIA;
            assert!((found - effort).abs() < tolerance, "{settings} {t}: {found} {effort}");
            assert!((rate - speed).abs() < 10.0 * tolerance, "{settings} {t}: {rate} {speed}");
        }
        assert!(metrics.max_energy_error_j < 100.0 * tolerance, "{metrics:?}");
    }
}

#[test]
fn a_sine_is_attenuated_and_delayed() {
    // u is constant from tick to tick at 10 kHz: T dz/dt = u - z with a sine of w = 50, w T = 1.5.
    // A sampled sine is late by half a tick and its amplitude falls by (w t)^2 / 24 = 1e-6.
    let w: f64 = 50.0;
    let text = driven("control = { rate = 10000.0 }", "mode = \"force\"", 0.6);
    let mut sim = simulation(Some(&wheel(INERTIA)), &text, Some(move |_, t: f64| [0.0, 0.0, (w * t).sin()]));
    let mut recording = Recording::default();
    finish(&mut sim, &mut recording);
    let (amplitude, phase) = ((1.0 + (w * T).powi(2)).sqrt().recip(), (w * T).atan());
    for s in recording.snapshots.iter().filter(|s| s.time > 0.4) {
        let start = amplitude * phase.sin() * (-s.time / T).exp();
        let expected = amplitude * (w * (s.time - 0.5e-4) - phase).sin() + start;
        // The ripple of one tick: w dt / 2 of dt / T.
        assert!((s.effort[0] - expected).abs() < 1e-5, "{}: {} {expected}", s.time, s.effort[0]);
    }
}

#[test]
fn a_position_servo_with_lag_obeys_its_characteristic_cubic() {
    // I T s^3 + I s^2 + kd s + kp = 0, by an independent integration of the three equations.
    let (kp, kd) = (40.0, 3.0);
    let drive = format!("mode = \"position\", kp = {kp}, kd = {kd}");
    for (settings, tolerance) in
        EXPLICIT.into_iter().chain([("integrator = { method = \"semi-implicit\", step = 1e-5 }", 2e-4)])
    {
        let text = driven(settings, &drive, 0.5) + "velocity = { axle = 1.5 }\n";
        let mut sim = simulation(Some(&wheel(INERTIA)), &text, NO_COMMANDS);
        let metrics = finish(&mut sim, &mut NullObserver);
        // At the start the actuator exerts the servo effort: -kd qd.
        let f = |_: f64, [q, v, z]: &[f64; 3]| [*v, z / INERTIA, (-kp * q - kd * v - z) / T];
        let [q, v, z] = rk4([0.0, 1.5, -kd * 1.5], 0.5, 100_000, f);
        let state = &sim.plant().state;
        for (mine, truth) in [(state.joints[0], q), (state.v[0], v), (state.actuators[0], z)] {
            assert!((mine - truth).abs() < 10.0 * tolerance, "{settings}: {mine} {truth}");
        }
        assert!(metrics.max_energy_error_j < 10.0 * tolerance, "{settings} {metrics:?}");
        // The roots, a real one and a pair, and the solution through them.
        let roots = roots(INERTIA * T, INERTIA, kd, kp);
        let exact = modes(&roots, [0.0, 1.5, -kd * 1.5 / INERTIA], 0.5);
        assert!((q - exact).abs() < 1e-11, "{q} {exact}");
    }
}

/// Roots of `a s^3 + b s^2 + c s + d` by the Durand-Kerner iteration.
fn roots(a: f64, b: f64, c: f64, d: f64) -> [nalgebra::Complex<f64>; 3] {
    use nalgebra::Complex;
    let scale = (d / a).abs().cbrt();
    let mut x = [0.4, 2.5, 4.6].map(|angle: f64| Complex::from_polar(scale, angle));
    for _ in 0..200 {
        for i in 0..3 {
            let value = ((x[i] * a + b) * x[i] + c) * x[i] + d;
            let others: Complex<f64> = (0..3).filter(|j| *j != i).map(|j| x[i] - x[j]).product();
            x[i] -= value / (others * a);
        }
    }
    x
}

/// The sum of exponentials with these rates that has this initial value, slope and curvature, at
/// time `t`.
fn modes(rates: &[nalgebra::Complex<f64>; 3], start: [f64; 3], t: f64) -> f64 {
    use nalgebra::{Complex, Matrix3, Vector3};
    let vandermonde = Matrix3::from_fn(|r, c| rates[c].powi(r as i32));
    let start = Vector3::from_fn(|r, _| Complex::from(start[r]));
    let weights = vandermonde.lu().solve(&start).expect("distinct rates");
    (0..3).map(|i| weights[i] * (rates[i] * t).exp()).sum::<Complex<f64>>().re
}

#[test]
fn a_negligible_lag_does_not_change_the_motion() {
    // Velocity-level steps of 1e-3 with T = 1e-9: the mean effort is the servo effort at the end of
    // the step, including implicit gains.
    let text = |lag: &str| {
        format!(
            "duration = 0.5
            integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
            [robot]
            model = \"given\"
            soles = []
            posture = {{ a = 0.4 }}
            joint = {{ a = {{ kp = 200.0, kd = 8.0{lag} }}, b = {{ kp = 20.0, kd = 1.0{lag} }} }}
            [[task]]
            type = \"posture\"
            duration = 0.3
            joints = {{ a = -0.5, b = 0.7 }}\n"
        )
    };
    let arm = robot(&[
        "<link name=\"world\"/>".into(),
        hinge("a", "world", "upper", 0.0, "0 1 0"),
        link("upper", 1.0, 0.2, 0.01),
        hinge("b", "upper", "lower", 0.4, "0 1 0"),
        link("lower", 0.5, 0.1, 0.003),
    ]);
    let end = |lag: &str| {
        let mut sim = simulation(Some(&arm), &text(lag), NO_COMMANDS);
        finish(&mut sim, &mut NullObserver);
        sim.plant().state.clone()
    };
    let (plain, short) = (end(""), end(", lag = 1e-9"));
    // T / dt = 1e-6 of the efforts' changes in a step.
    for (a, b) in plain.joints.iter().chain(&plain.v).zip(short.joints.iter().chain(&short.v)) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    assert!((end(", lag = 0.02").joints[1] - plain.joints[1]).abs() > 1e-4, "a long one does not");
}
