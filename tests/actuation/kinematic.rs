//! Kinematic joints: prescribed motions in a robot with dynamics.

use super::{NO_COMMANDS, hinge, link, robot, simulation};
use crate::analytic::body::G;
use crate::support::runs::{Recording, finish, rk4, root};
use stiction::assemble;
use stiction::dynamics::body;
use stiction::scenario;
use stiction::sim::NullObserver;

const TIGHT: &str = "integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }";

/// A free body of mass `M` and inertia `I` with an arm `(m, i)`: hinge `A` from its centre, arm's
/// centre `B` further.
const M: f64 = 3.0;
const I: f64 = 0.02;
const A: f64 = 0.1;
const B: f64 = 0.25;

fn floating(m: f64, i: f64) -> String {
    robot(&[link("body", M, 0.0, I), hinge("arm", "body", "rod", A, "0 0 1"), link("rod", m, B, i)])
}

/// Rotation of the body against the arm per turn of the arm, at the angle `theta` between them,
/// without angular momentum:
///
/// ```text
/// I f' + i (f' + t') + u (a^2 f' + b^2 (f' + t') + a b cos t (2 f' + t')) = 0,   u = M m / (M + m)
/// ```
fn recoil(m: f64, i: f64, theta: f64) -> f64 {
    let u = M * m / (M + m);
    let cross = A * B * theta.cos();
    -(i + u * (B * B + cross)) / (I + i + u * (A * A + B * B + 2.0 * cross))
}

/// Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let (n, h) = (2000, (to - from) / 2000.0);
    let weight = |k: usize| if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    (0..=n).map(|k| weight(k) * f(from + h * k as f64)).sum::<f64>() * h / 3.0
}

fn swing(settings: &str, drive: &str) -> String {
    format!(
        "duration = 0.6
        gravity = [0, 0, 0]
        log = {{ rate = 100.0 }}
        {settings}
        [robot]
        model = \"\"
        base = {{ position = [0, 0, 0] }}
        soles = []
        joint_default = {drive}
        [[task]]
        type = \"posture\"
        duration = 0.5
        joints = {{ arm = 1.2 }}\n"
    )
    .replace("model = \"\"", "model = \"given\"")
}

#[test]
fn a_body_recoils_from_its_prescribed_arm_by_the_closed_form() {
    // From a massless arm to one that is heavier than the body.
    for (m, i) in [(1e-6, 1e-9), (0.5, 1e-3), (8.0, 0.3)] {
        // First order with steps of 1e-4; error control at 1e-10; fixed steps of 1e-3 at order 4.
        for (settings, tolerance) in [
            (TIGHT, 1e-10),
            ("integrator = { method = \"bs23\", relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }", 1e-8),
            ("integrator = { method = \"rk4\", step = 1e-3 }", 1e-9),
            ("integrator = { method = \"semi-implicit\", step = 1e-4 }", 1e-3),
        ] {
            let mut sim = simulation(Some(&floating(m, i)), &swing(settings, "{ mode = \"kinematic\" }"), NO_COMMANDS);
            let mut recording = Recording::default();
            let metrics = finish(&mut sim, &mut recording);
            let state = &sim.plant().state;
            assert_eq!((state.joints[0], state.v[6]), (1.2, 0.0), "to the last bit");
            let truth = integral(|theta| recoil(m, i, theta), 0.0, 1.2);
            let yaw = state.rotation.scaled_axis().z;
            assert!((yaw - truth).abs() < tolerance, "{settings} {m}: {yaw} {truth}");
            // Momentum: no external force acts.
            let (size, speed) = (M + m, 1.0);
            let worst = recording.snapshots.iter().map(|s| s.com_velocity.norm()).fold(0.0, f64::max);
            assert!(worst < tolerance * speed, "{settings}: {worst}");
            assert!(body::momentum(&sim.plant().ws).angular.norm() < tolerance * size, "{settings}");
            // At rest again: the drive has absorbed as much work as it supplied.
            let energy = 0.5 * m * B * B * (1.2f64 * 15.0 / 8.0 / 0.5).powi(2);
            if !settings.contains("semi") {
                assert!(metrics.actuator_work_j.abs() < 10.0 * tolerance * energy.max(1e-3), "{metrics:?}");
                assert!(metrics.max_energy_error_j < 10.0 * tolerance * energy.max(1e-3), "{metrics:?}");
            }
        }
    }
}

#[test]
fn steps_do_not_depend_on_how_light_the_link_is() {
    let steps = |m: f64| {
        let text = swing("", "{ mode = \"kinematic\" }");
        let metrics = finish(&mut simulation(Some(&floating(m, 1e-3 * m)), &text, NO_COMMANDS), &mut NullObserver);
        (metrics.steps, metrics.rejected_steps)
    };
    assert_eq!(steps(1e-6), steps(1e-9));
    assert_eq!(steps(1e-6).1, 0);
}

/// The double pendulum of robots/pendulum (see analytic::pendulum), its shoulder rotated as
/// commanded.
const PENDULUM: &str = "
    duration = 1.5
    log = { rate = 100.0 }
    [robot]
    model = \"robots/pendulum/pendulum.urdf\"
    soles = []
    joint_default = { mode = \"passive\" }
    joint = { shoulder = { mode = \"kinematic\" } }
    posture = { shoulder = 0.4, elbow = 0.3 }
";

/// Acceleration of the lower bar's absolute angle `b` under an upper one that moves as `[a, a', a'']`.
fn lower(a: [f64; 3], b: f64, _q: f64) -> f64 {
    let (m, l, c, i) = (1.0, 0.5, 0.25, 0.25040 / 12.0);
    let d = a[0] - b;
    (m * l * c * (d.sin() * a[1] * a[1] - d.cos() * a[2]) - m * c * G * b.sin()) / (i + m * c * c)
}

/// Effort of the shoulder: both equations of the double pendulum added.
fn shoulder(a: [f64; 3], b: f64, q: f64) -> f64 {
    let (m, l, c, i) = (1.0, 0.5, 0.25, 0.25040 / 12.0);
    let (d, acceleration) = (a[0] - b, lower(a, b, q));
    let upper = (i + m * c * c + m * l * l) * a[2] + m * l * c * (d.cos() * acceleration + d.sin() * q * q);
    upper + m * (c + l) * G * a[0].sin()
}

#[test]
fn a_pendulum_on_a_uniformly_rotating_shoulder_obeys_its_equation_of_motion() {
    let w = 2.5;
    let text = format!("{TIGHT}\n{PENDULUM}\nvelocity = {{ shoulder = {w}, elbow = -0.5 }}");
    let mut sim = simulation(None, &text, Some(move |j, t| if j == 0 { [0.4 + w * t, w, 0.0] } else { [0.0; 3] }));
    let mut recording = Recording::default();
    let metrics = finish(&mut sim, &mut recording);
    let upper = |t: f64| [0.4 + w * t, w, 0.0];
    let [b, q] = rk4([0.7, w - 0.5], 1.5, 100_000, |t, [b, q]| [*q, lower(upper(t), *b, *q)]);
    let state = &sim.plant().state;
    // Integration at 1e-10 over 1500 steps.
    assert!((state.joints[0] - upper(1.5)[0]).abs() < 1e-13 && (state.v[0] - w).abs() < 1e-12, "{state:?}");
    assert!((state.joints[0] + state.joints[1] - b).abs() < 1e-8, "{} {b}", state.joints[0] + state.joints[1]);
    assert!((state.v[0] + state.v[1] - q).abs() < 1e-7);
    // The reported effort is what rotates the shoulder; it is far from zero. It contains the
    // rounding of q over T^2.
    let last = recording.snapshots.last().expect("one");
    assert!(
        (last.effort[0] - shoulder(upper(1.5), b, q)).abs() < 1e-6,
        "{} {}",
        last.effort[0],
        shoulder(upper(1.5), b, q)
    );
    assert!(last.effort[0].abs() > 1.0);
    // Its work is the change of energy.
    assert!(metrics.actuator_work_j.abs() > 1.0 && metrics.max_energy_error_j < 1e-8, "{metrics:?}");
}

#[test]
fn smooth_commands_are_followed_without_delay() {
    // a = 0.4 + 0.5 (1 - cos w t): the first tick has no acceleration yet and ends a T^2 / 2 short,
    // the second makes up for it.
    let w = 4.0;
    let upper = move |t: f64| {
        let (s, c) = (w * t).sin_cos();
        [0.4 + 0.5 * (1.0 - c), 0.5 * w * s, 0.5 * w * w * c]
    };
    let text = format!("{TIGHT}\n{PENDULUM}");
    let mut sim =
        simulation(None, &text, Some(move |j, t| if j == 0 { [upper(t)[0], upper(t)[1], 0.0] } else { [0.0; 3] }));
    let mut recording = Recording::default();
    finish(&mut sim, &mut recording);
    for s in &recording.snapshots[1..] {
        let [q, qd, _] = upper(s.time);
        // The fourth derivative, w^4 / 2, over 6 and 2, with T = 1e-3.
        let fourth = 0.5 * w.powi(4);
        assert!((s.q[0] - q).abs() < fourth * 1e-12 / 6.0 + 1e-14, "{} {:e}", s.time, s.q[0] - q);
        assert!((s.qd[0] - qd).abs() < fourth * 1e-9 / 2.0 + 1e-12, "{} {:e}", s.time, s.qd[0] - qd);
    }
    let [b, q] = rk4([0.7, 0.0], 1.5, 100_000, |t, [b, q]| [*q, lower(upper(t), *b, *q)]);
    let state = &sim.plant().state;
    // First tick: the velocity at its end is a T too low, for two ticks; a = 8.
    assert!((state.joints[0] + state.joints[1] - b).abs() < 2e-5, "{:e}", state.joints[0] + state.joints[1] - b);
    assert!((state.v[0] + state.v[1] - q).abs() < 1e-4);
    // A share of six times the third derivative per tick would appear as a saw-tooth; the effort is
    // smooth.
    let smooth = shoulder(upper(1.5), b, q);
    assert!((recording.snapshots.last().expect("one").effort[0] - smooth).abs() < 1e-3, "{smooth}");
}

#[test]
fn a_command_that_jumps_is_reached_within_one_tick() {
    let step = |t: f64| if t < 0.5 { 0.4 } else { 0.5 };
    let mut sim = simulation(None, PENDULUM, Some(move |_, t| [step(t), 0.0, 0.0]));
    let mut recording = Recording::default();
    let metrics = finish(&mut sim, &mut recording);
    for s in &recording.snapshots {
        // At the instant itself the command is new and the joint still has its old position.
        let expected = if s.time < 0.5005 { 0.4 } else { 0.5 };
        assert!((s.q[0] - expected).abs() < 1e-15, "{} {}", s.time, s.q[0]);
    }
    // 0.1 rad within a millisecond, at 150 rad/s: about 0.5 kg m^2 hold 5600 J on the way. The
    // integrator's tolerance of 1e-6 is relative to that energy.
    assert!(metrics.max_energy_error_j < 1e-6 * 5600.0 && metrics.impacts == 0, "{metrics:?}");
}

#[test]
fn a_sole_carried_only_by_kinematic_joints_is_refused() {
    let text = |mode: &str| {
        PENDULUM.replace("soles = []", "soles = [{ name = \"tip\", link = \"lower\", polygon = [[0, 0, -0.5]] }]")
            + &format!("joint.elbow = {{ mode = \"{mode}\" }}\n")
    };
    let setup = |mode: &str| {
        let text = text(mode)
            .replace("joint = { shoulder = { mode = \"kinematic\" } }", "joint.shoulder = { mode = \"kinematic\" }");
        let file = scenario::parse(&root().join("test.toml"), &text).unwrap_or_else(|e| panic!("{e}"));
        let run = file.expand(&[]).unwrap_or_else(|e| panic!("{e}")).remove(0);
        let robot = stiction::robot::load(&run.resolve(&run.scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"));
        assemble::setup(&run, &robot).map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(setup("passive"), Ok(()));
    let message = setup("kinematic").expect_err("nothing could hold it");
    assert!(message.contains("sole `tip` moves as prescribed") && message.contains("test.toml:5:"), "{message}");
}

/// HOAP-2 with its head kinematic, nodding, on the floor or above it.
fn nodding(settings: &str, height: f64) -> String {
    let z = 0.284 + height;
    format!(
        "duration = 1.0
        {settings}
        [robot]
        model = \"robots/hoap2/hoap2.toml\"
        base = {{ position = [0.0, 0.0, {z}] }}
        joint = {{ head_pan = {{ mode = \"kinematic\" }}, head_tilt = {{ mode = \"kinematic\" }} }}
        [[task]]
        type = \"posture\"
        start = 0.05
        duration = 0.3
        joints = {{ head_pan = 0.6, head_tilt = 0.4 }}\n"
    )
}

#[test]
fn a_robot_stands_and_lands_while_its_kinematic_head_nods() {
    for height in [0.0, 0.02] {
        for (settings, closes) in [
            ("", 1e-4),
            ("contact = { method = \"one-step\" }", 1e-3),
            ("contact = { method = \"penalty\" }", 1e-4),
            ("integrator = { method = \"semi-implicit\", step = 1e-3 }", 1e-1),
            ("integrator = { method = \"semi-implicit\", step = 1e-3 }\ncontact = { method = \"lcp\" }", 1e-1),
            ("integrator = { method = \"semi-implicit\", step = 1e-3 }\ncontact = { method = \"ncp\" }", 1e-1),
        ] {
            let mut sim = simulation(None, &nodding(settings, height), NO_COMMANDS);
            let mut recording = Recording::default();
            let metrics = finish(&mut sim, &mut recording);
            let model = sim.plant().model.clone();
            let last = recording.snapshots.last().expect("one");
            for (name, angle) in [("head_pan", 0.6), ("head_tilt", 0.4)] {
                let j = model.joint(name).expect("has a head").0;
                assert_eq!(last.q[j], angle, "{settings}");
                assert!(last.effort[j].abs() < 0.2 && last.effort[j] != 0.0, "{}", last.effort[j]);
            }
            println!("{settings} {height}: {metrics:?}");
            let load: f64 = last.soles.iter().flat_map(|s| &s.forces).map(|f| f.z).sum();
            assert!((load / (model.mass() * G) - 1.0).abs() < 0.02, "{settings} {load}");
            assert!(metrics.max_energy_error_j < closes, "{settings} {height}: {}", metrics.max_energy_error_j);
        }
    }
}
