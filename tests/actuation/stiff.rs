//! Stiff drives with implicit integrators: closed forms, and fewer steps than explicit ones.

use super::{link, robot, simulation, wheel};
use crate::support::runs::{self, Recording, finish, run};
use nalgebra::{Matrix3, Vector3};
use stiction::sim::{Metrics, NullObserver};

const INERTIA: f64 = 0.2;
const END: f64 = 0.5;

/// A wheel that a servo with these keys turns from 0 to 1 rad.
fn turned(method: &str, tolerance: f64, servo: &str) -> (Metrics, Recording) {
    let text = format!(
        "duration = {END}
        gravity = [0, 0, 0]
        log.rate = 200.0
        control.rate = 1.0
        integrator = {{ method = \"{method}\", relative_tolerance = {tolerance}, absolute_tolerance = {tolerance} }}
        robot = {{ model = \"given\", soles = [], joint.axle = {{ {servo} }} }}\n"
    );
    let mut sim = simulation(Some(&wheel(INERTIA)), &text, Some(|_, _| [1.0, 0.0, 0.0]));
    let mut seen = Recording::default();
    (finish(&mut sim, &mut seen), seen)
}

/// Greatest distance of the logged positions from `exp(A t) (0, 0, z) + equilibrium` of the linear system with state
/// `(q - 1, v, effort)`.
fn distance(seen: &Recording, a: Matrix3<f64>, start: Vector3<f64>) -> f64 {
    let off = |(time, q): (f64, f64)| (q - 1.0 - ((a * time).exp() * start)[0]).abs();
    seen.snapshots.iter().map(|s| off((s.time, s.q[0]))).fold(0.0, f64::max)
}

#[test]
fn an_overdamped_servo_approaches_as_its_closed_form_in_few_steps() {
    // Rates of 50 and 2e5 1/s: the second ends within 0.1 ms.
    let (kp, kd) = (2e6, 4e4);
    let a = Matrix3::new(0.0, 1.0, 0.0, -kp / INERTIA, -kd / INERTIA, 0.0, 0.0, 0.0, 0.0);
    let servo = format!("kp = {kp}, kd = {kd}, effort = 1e9");
    for (method, tolerance) in [("rosenbrock", 1e-5), ("rosenbrock", 1e-7), ("bdf", 1e-5), ("bdf", 1e-7)] {
        let (m, seen) = turned(method, tolerance, &servo);
        let error = distance(&seen, a, Vector3::new(-1.0, 0.0, 0.0));
        // Errors of the steps add up over the rise; the log's dense output is of order 2.
        assert!(error < 10.0 * tolerance, "{method} {error}");
        assert!(m.steps < 20.0f64.mul_add(tolerance.powf(-1.0 / 3.0), 100.0) as u64, "{method} {}", m.steps);
    }
}

#[test]
fn a_lagging_servo_follows_its_linear_equations() {
    // A rate of 1e5 1/s, at which the effort follows.
    let (kp, kd, lag) = (400.0, 40.0, 1e-5);
    let a = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0 / INERTIA, -kp / lag, -kd / lag, -1.0 / lag);
    for method in ["rosenbrock", "bdf"] {
        let (m, seen) = turned(method, 1e-7, &format!("kp = {kp}, kd = {kd}, lag = {lag}, effort = 1e9"));
        // The effort begins as that of the servo's first command.
        let error = distance(&seen, a, Vector3::new(-1.0, 0.0, kp));
        assert!(error < 1e-6, "{method} {error}");
        // Explicit steps of at most 3e-5 s would be 15 000.
        assert!(m.steps < 1500, "{method} {}", m.steps);
    }
}

#[test]
fn auto_becomes_implicit_where_stability_limits_explicit_steps() {
    let servo = "kp = 2e6, kd = 4e4, effort = 1e9";
    let steps = |method| turned(method, 1e-6, servo).0.steps;
    let (explicit, auto, implicit) = (steps("dopri5"), steps("auto"), steps("rosenbrock"));
    // Stability: 2e5 1/s over 0.5 s at 3.3 a step.
    assert!(explicit > 30_000, "{explicit}");
    assert!(auto < implicit + 300 && implicit < 1000, "{auto} {implicit}");
}

/// A foot of 0.1 kg slides at 5e-6 m/s, at which the rate of friction across its way is 1e6 1/s, driven by a servo with a
/// rate of 1e5 1/s: steps with implicit friction alone are limited by the servo.
#[test]
fn auto_becomes_implicit_where_friction_is_stiff_too() {
    let sole = |link: &str, size: f64| {
        format!(
            "{{ name = \"{link}\", link = \"{link}\", polygon = [[{size}, {size}, 0], [-{size}, {size}, 0],
            [-{size}, -{size}, 0], [{size}, -{size}, 0]] }}"
        )
    };
    let prismatic = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"prismatic\"><parent link=\"{parent}\"/><child link=\"{child}\"/>
            <axis xyz=\"{axis}\"/><limit lower=\"-1\" upper=\"1\" effort=\"1e9\" velocity=\"1e9\"/></joint>"
        )
    };
    let parts = [
        link("body", 1.0, 0.0, 0.01),
        prismatic("drive", "body", "carriage", "1 0 0"),
        link("carriage", 0.01, 0.0, 1e-4),
        prismatic("side", "carriage", "slide", "0 1 0"),
        link("slide", 0.01, 0.0, 1e-4),
        prismatic("rise", "slide", "foot", "0 0 1"),
        link("foot", 0.1, 0.0, 1e-3),
    ];
    let ended = |method: &str| {
        let text = format!(
            "duration = 0.05
            log.rate = 0
            control.rate = 1.0
            integrator.method = \"{method}\"
            floor.friction = 0.5
            robot = {{ model = \"given\", base.position = [0, 0, 0], soles = [{}, {}], joint.rise.mode = \"passive\",
                joint.side.mode = \"passive\", joint.drive = {{ kp = 1e5, kd = 1e4 }}, velocity.drive = 5e-6 }}\n",
            sole("body", 0.2),
            sole("foot", 0.01)
        );
        let mut sim = simulation(Some(&robot(&parts)), &text, Some(|j, _| [5.4e-6 * f64::from(j == 0), 0.0, 0.0]));
        let m = finish(&mut sim, &mut NullObserver);
        (m.steps, sim.plant().state.joints[0])
    };
    let ((explicit, truth), (auto, found), (implicit, _)) = (ended("dopri5"), ended("auto"), ended("rosenbrock"));
    // The foot carries 0.981 N, so friction takes 0.4905 of 0.54 N.
    let expected = (5.4e-6 - 4.905e-6) * (1.0 - (-0.05f64 * 10.0).exp());
    assert!((truth / expected - 1.0).abs() < 1e-3 && (found - truth).abs() < 1e-10, "{truth} {found} {expected}");
    assert!(explicit > 1500, "{explicit}");
    assert!(auto < implicit + 100 && implicit < 100, "{auto} {implicit}");
}

/// HOAP-2 swings its arms as in `scenarios/studies/work-precision-servo.toml`. Implicit steps are little longer than
/// stable explicit ones.
#[test]
fn auto_does_not_resume_explicit_steps_that_stability_would_limit() {
    let steps = |method: &str| {
        let text = format!(
            "duration = 0.5
            log.rate = 0
            control = {{ rate = 100, interpolation = \"cubic\" }}
            integrator.method = \"{method}\"
            robot = {{ model = \"robots/hoap2/hoap2.urdf\", contact = \"soles\", joint_default = {{ kp = 50, kd = 1 }} }}
            [[task]]
            type = \"sine\"
            ramp = 0.2
            [task.joints]
            left_shoulder_pitch = {{ amplitude = 0.2, frequency = 1.0 }}
            right_shoulder_pitch = {{ amplitude = -0.2, frequency = 1.0 }}\n"
        );
        run(&text).steps
    };
    let (auto, implicit) = (steps("auto"), steps("bdf"));
    // Explicit steps of half this size would make them 1.5 times as many.
    assert!(10 * auto < 11 * implicit, "{auto} {implicit}");
}

#[test]
fn auto_has_the_bits_of_the_explicit_method_where_nothing_is_stiff() {
    let end = |method| {
        let (_, seen) = turned(method, 1e-6, "kp = 20.0, kd = 1.0, effort = 1e9");
        seen.snapshots.last().expect("one").q[0].to_bits()
    };
    assert_eq!(end("auto"), end("dopri5"));
}

/// Ends of runs in which a servo of rates 11 and 89 1/s follows t^2 at 100 Hz for 3 s: distance from the motion
/// `t^2 - 2 I / kp`, and steps.
fn following(integrator: &str, interpolation: &str) -> (f64, u64) {
    let (kp, kd) = (200.0, 20.0);
    let text = format!(
        "duration = 3.005
        gravity = [0, 0, 0]
        log.rate = 0
        control = {{ rate = 100.0, interpolation = \"{interpolation}\" }}
        integrator = {{ {integrator} }}
        robot = {{ model = \"given\", soles = [], joint.axle = {{ kp = {kp}, kd = {kd}, effort = 1e9 }} }}\n"
    );
    let mut sim = simulation(Some(&wheel(INERTIA)), &text, Some(|_, t| [t * t, 2.0 * t, 0.0]));
    let m = finish(&mut sim, &mut NullObserver);
    let state = &sim.plant().state;
    ((state.joints[0] - state.time * state.time + 2.0 * INERTIA / kp).abs(), m.steps)
}

#[test]
fn interpolated_commands_are_continuous_between_ticks() {
    let tight = "method = \"dopri5\", relative_tolerance = 1e-10, absolute_tolerance = 1e-12";
    let (cubic, steps) = following(tight, "cubic");
    // The transient of the start has decayed by exp(-34); errors of 1e-10 of 9 rad.
    assert!(cubic < 1e-9, "{cubic}");
    // Held ones lag by half a tick of the velocity.
    let (held, of_held) = following(tight, "hold");
    assert!((held - 0.03).abs() < 0.01, "{held}");
    assert!(3 * steps < 2 * of_held, "{steps} {of_held}");
    // With its tolerance of 1e-6 of 9 rad.
    for method in ["rosenbrock", "bdf"] {
        let (implicit, _) = following(&format!("method = \"{method}\""), "cubic");
        assert!(implicit < 1e-5, "{method} {implicit}");
    }
    // Semi-implicit steps meet them too: the order is 1.
    let end = |h: f64| following(&format!("method = \"semi-implicit\", step = {h}"), "cubic").0;
    let (coarse, fine) = (end(1e-3), end(5e-4));
    assert!(coarse < 1e-2 && (coarse / fine - 2.0).abs() < 0.1, "{coarse} {fine}");
}

/// HOAP-2 with stiff servos, whose arms are turned by a velocity at the start.
fn humanoid(integrator: &str, contact: &str) -> (Vec<f64>, Metrics) {
    logged_humanoid(integrator, contact, 0.0)
}

/// The same with a log.
fn logged_humanoid(integrator: &str, contact: &str, rate: f64) -> (Vec<f64>, Metrics) {
    let mut sim = runs::simulation(&format!(
        "duration = 0.2
        log.rate = {rate:?}
        integrator = {{ {integrator} }}
        contact.method = \"{contact}\"
        robot = {{ model = \"robots/hoap2/hoap2.urdf\", contact = \"soles\", joint_default = {{ kp = 50, kd = 1 }}, velocity = {{ left_shoulder_pitch = 1.0, right_elbow = -0.5 }} }}\n"
    ));
    let metrics = finish(&mut sim, &mut NullObserver);
    let state = &sim.plant().state;
    ([&state.joints[..], &state.v, state.position.as_slice()].concat(), metrics)
}

#[test]
fn a_standing_humanoid_with_stiff_servos_moves_as_with_explicit_steps() {
    let tight = "relative_tolerance = 1e-9, absolute_tolerance = 1e-11";
    for contact in ["exact", "one-step", "penalty"] {
        let (truth, _) = humanoid(tight, contact);
        let (explicit, of_explicit) = humanoid("method = \"dopri5\"", contact);
        let error = |x: &[f64]| x.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        for method in ["rosenbrock", "bdf"] {
            let (found, m) = humanoid(&format!("method = \"{method}\""), contact);
            // Tolerance 1e-6 relative to speeds of 1 rad/s.
            assert!(error(&found) < 1e-6, "{method} {contact} {} {}", error(&found), error(&explicit));
            assert!(3 * m.steps < of_explicit.steps, "{method} {contact} {} {}", m.steps, of_explicit.steps);
            assert!(m.max_energy_error_j < 1e-6 && m.inconsistent == 0, "{method} {m:?}");
        }
    }
}

/// HOAP-2 swings its arms with stiff servos.
#[test]
fn smooth_motion_takes_fewer_evaluations_with_a_tenth_of_the_error() {
    for mode in ["position", "kinematic"] {
        smooth_motion(mode);
    }
}

fn smooth_motion(mode: &str) {
    let end = |integrator: &str| {
        let mut sim = runs::simulation(&format!(
            "duration = 0.6
            log.rate = 0
            control.interpolation = \"continuous\"
            integrator = {{ {integrator} }}
            [robot]
            model = \"robots/hoap2/hoap2.urdf\"
            contact = \"soles\"
            joint_default = {{ kp = 50, kd = 1 }}
            joint.left_shoulder_pitch.mode = \"{mode}\"
            [[task]]
            type = \"sine\"
            [task.joints]
            left_shoulder_pitch = {{ amplitude = 0.05, frequency = 1.0 }}
            right_shoulder_pitch = {{ amplitude = 0.05, frequency = 1.0 }}\n"
        ));
        let metrics = finish(&mut sim, &mut NullObserver);
        let state = &sim.plant().state;
        ([&state.joints[..], &state.v, state.position.as_slice()].concat(), metrics)
    };
    let tolerance = "relative_tolerance = 1e-6, absolute_tolerance = 1e-6";
    let (truth, _) = end("relative_tolerance = 1e-10, absolute_tolerance = 1e-12");
    let of = |method: &str| {
        let (found, m) = end(&format!("method = \"{method}\", {tolerance}"));
        (found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max), m)
    };
    let ((rosenbrock, one), (smooth, two)) = (of("rosenbrock"), of("bdf"));
    assert!(smooth < 0.1 * rosenbrock, "{mode} {smooth} {rosenbrock}");
    assert!(two.evaluations < one.evaluations, "{mode} {one:?} {two:?}");
    assert_eq!((two.inconsistent, two.state_changes), (0, one.state_changes));
}

#[test]
fn a_smooth_step_needs_two_evaluations() {
    let (end, m) = humanoid("method = \"bdf\"", "exact");
    // The predicted end, and the end that the next step begins with. The first steps need two more each, as does the
    // choice of states.
    let others = m.evaluations as f64 - 2.0 * m.steps as f64 - m.rejected_steps as f64;
    assert!((0.0..40.0).contains(&others) && m.steps > 500, "{m:?}");
    let (logged, of_logged) = logged_humanoid("method = \"bdf\"", "exact", 700.0);
    assert_eq!((&end, m.steps), (&logged, of_logged.steps));
}

/// The start of a step has been evaluated as the end of the step before, with the same bits as if it were evaluated anew:
/// logs, which evaluate the end again, change nothing.
#[test]
fn a_step_needs_four_evaluations() {
    for contact in ["exact", "penalty"] {
        let (end, m) = humanoid("method = \"rosenbrock\"", contact);
        let (steps, rejected) = (m.steps as f64, m.rejected_steps as f64);
        // Three stages and the end. Responses to forces are not counted; events and the start are.
        let others = m.evaluations as f64 - 4.0 * steps - 3.0 * rejected;
        assert!(others >= 0.0 && others < 0.25 * steps + 20.0, "{contact} {m:?}");
        let (logged, of_logged) = logged_humanoid("method = \"rosenbrock\"", contact, 700.0);
        assert_eq!((&end, m.steps), (&logged, of_logged.steps), "{contact}");
    }
}

#[test]
fn a_stop_does_not_limit_the_steps() {
    let stop = "joint.axle = { mode = \"force\", stop = { stiffness = 1e7, damping = 2e4 } }";
    let text = |method: &str| {
        format!(
            "duration = 1.0
            gravity = [0, 0, 0]
            log.rate = 0
            control.rate = 1.0
            integrator.method = \"{method}\"
            robot = {{ model = \"given\", soles = [], velocity = {{ axle = 2.0 }}, {stop} }}\n"
        )
    };
    let urdf = wheel(INERTIA)
        .replace("continuous\">", "revolute\"><limit lower=\"-9\" upper=\"0.5\" effort=\"9\" velocity=\"99\"/>");
    let end = |method: &str| {
        let mut sim = simulation(Some(&urdf), &text(method), Some(|_, _| [0.0, 0.0, 5.0]));
        let m = finish(&mut sim, &mut NullObserver);
        (sim.plant().state.joints[0], m.steps)
    };
    let (truth, explicit) = end("dopri5");
    for method in ["rosenbrock", "bdf"] {
        let (found, implicit) = end(method);
        // At rest the spring carries the drive's 5 N m.
        assert!((found - 0.5 - 5e-7).abs() < 1e-10 && (truth - found).abs() < 1e-10, "{method} {found} {truth}");
        assert!(10 * implicit < explicit, "{method} {implicit} {explicit}");
    }
}

#[test]
fn a_landing_is_located_with_implicit_steps() {
    let fall = (2.0 * 0.3f64 / 9.81).sqrt();
    for method in ["rosenbrock", "bdf", "auto"] {
        let m = run(&format!(
            "duration = 0.5
            log.rate = 0
            integrator = {{ method = \"{method}\", relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
            robot = {{ model = \"robots/block/block.toml\", base.position = [0, 0, 0.35] }}\n"
        ));
        // The fall is of order 2, so exact up to rounding.
        assert!((m.first_touchdown_s.expect("it lands") / fall - 1.0).abs() < 1e-12, "{method}");
        assert_eq!((m.impacts, m.inconsistent), (1, 0));
    }
}

#[test]
fn a_compliant_floor_does_not_limit_the_steps() {
    let stands = |integrator: &str, duration: f64| {
        let mut sim = runs::simulation(&format!(
            "duration = {duration}
            log.rate = 0
            integrator.method = \"{integrator}\"
            contact.method = \"penalty\"
            robot.model = \"robots/hoap2/hoap2.toml\"\n"
        ));
        let m = finish(&mut sim, &mut NullObserver);
        (sim.plant().state.position, m)
    };
    let (truth, explicit) = stands("dopri5", 0.5);
    // Friction turns at mu_k N / (m s), 5e4 1/s for the light foot.
    assert!(explicit.steps > 5000, "{}", explicit.steps);
    for integrator in ["rosenbrock", "bdf", "auto"] {
        let (found, m) = stands(integrator, 0.5);
        // The absolute tolerance, over the oscillations of the landing.
        assert!((found - truth).norm() < 1e-8, "{integrator} {}", found - truth);
        // Formulas take more steps of fewer evaluations after the landing.
        assert!(7 * m.evaluations < explicit.evaluations && m.max_energy_error_j < 1e-8, "{integrator} {m:?}");
        // Once it rests only `max_step` limits the steps.
        let (_, m) = stands(integrator, 10.0);
        assert!(m.steps < 3000, "{integrator} {}", m.steps);
    }
}

#[test]
fn viscous_friction_of_any_strength_decays_as_its_closed_form() {
    // A rate of 5e5 1/s from a force model, and one of 2 1/s from the joint.
    for (damping, rate) in [(1e5, 5e5), (0.4, 2.0)] {
        let text = format!(
            "duration = 1.0
            gravity = [0, 0, 0]
            log.rate = 0
            integrator.method = \"rosenbrock\"
            robot = {{ model = \"given\", soles = [], joint_default.mode = \"passive\", velocity = {{ axle = 2.0 }} }}
            [[force]]
            type = \"joint-friction\"
            joints.axle.viscous = {damping:?}\n"
        );
        let mut sim = simulation(Some(&wheel(INERTIA)), &text, None::<fn(usize, f64) -> [f64; 3]>);
        let m = finish(&mut sim, &mut NullObserver);
        let turned = 2.0 / rate * -f64::exp_m1(-rate);
        // Tolerance 1e-6 relative, 1e-8 absolute.
        assert!((sim.plant().state.joints[0] - turned).abs() < 1e-6, "{rate}");
        assert!((sim.plant().state.v[0] - 2.0 * (-rate).exp()).abs() < 1e-6, "{rate}");
        assert!(m.steps < 1000, "{rate}: {}", m.steps);
        let lost = 0.5 * INERTIA * (4.0 - sim.plant().state.v[0].powi(2));
        assert!((m.external_work_j + lost).abs() < 1e-5, "{rate}: {} {lost}", m.external_work_j);
    }
}
