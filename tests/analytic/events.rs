//! Events during a run: afterwards the motion is that of a run with the new values from the start.

use super::body::G;
use crate::support::runs::{TIGHT, finish, run, simulation, watch};
use stiction::dynamics::State;
use stiction::sim::NullObserver;

const BLOCK: &str = "model = \"robots/block/block.toml\"";

#[test]
fn a_block_slides_when_the_floor_turns_to_ice() {
    let angle = 0.2f64;
    for (mu, kinetic) in [(0.1, 0.1), (0.15, 0.05)] {
        let text = format!(
            "duration = 1.0\nfloor = {{ friction = 0.8, rpy = [0, {angle}, 0] }}\n{TIGHT}
            [robot]\n{BLOCK}\nbase = {{ rpy = [0, {angle}, 0] }}
            [[event]]\nat = 0.4\nset = {{ \"floor.friction\" = {{ static = {mu}, kinetic = {kinetic} }} }}"
        );
        let (m, recording) = watch(&text);
        let acceleration = G * (angle.sin() - kinetic * angle.cos());
        // Integration at 1e-9; a constant acceleration is integrated better than that.
        assert!((m.final_base_shift_m - 0.5 * acceleration * 0.36).abs() < 1e-10, "{}", m.final_base_shift_m);
        assert_eq!(m.first_slip_s, Some(0.4));
        assert!(m.energy_error_j.abs() < 1e-10 && m.inconsistent == 0);
        let event = recording.events.iter().find(|e| e.kind == "event").expect("it is reported");
        assert_eq!(event.time, 0.4);
        assert!(event.message.starts_with("floor.friction = {"), "{}", event.message);
    }
}

#[test]
fn every_stepping_scheme_responds_to_the_ice() {
    for how in [
        "contact = { method = \"one-step\" }",
        "contact = { method = \"ncp\" }\nintegrator = { method = \"semi-implicit\", step = 1e-3 }",
        "contact = { method = \"lcp\" }\nintegrator = { method = \"semi-implicit\", step = 1e-3 }",
        "contact = { method = \"exact\", events = \"step\" }\nintegrator = { method = \"rk4\", step = 1e-3 }",
        "contact = { method = \"penalty\" }",
    ] {
        let text = format!(
            "duration = 1.0\nfloor = {{ friction = 0.8, rpy = [0, 0.2, 0] }}\n{how}
            [robot]\n{BLOCK}\nbase = {{ rpy = [0, 0.2, 0] }}
            [[event]]\nat = 0.4\nset = {{ \"floor.friction\" = 0.1 }}"
        );
        let m = run(&text);
        let way = 0.5 * G * (0.2f64.sin() - 0.1 * 0.2f64.cos()) * 0.36;
        // First order in a step of 1e-3 s at speeds up to 0.6 m/s, and springs that deflect by half
        // a millimetre.
        assert!((m.final_base_shift_m - way).abs() < 2e-3, "{how}: {} not {way}", m.final_base_shift_m);
    }
}

#[test]
fn a_patch_appears_and_disappears() {
    // The block slides from (0, 0) at 1 m/s on ice; the floor has a rough patch below it for 0.1 s.
    let text = format!(
        "duration = 1.0\nfloor = {{ friction = 0 }}\n{TIGHT}
        [robot]\n{BLOCK}\nbase = {{ linear_velocity = [1, 0, 0] }}
        [[event]]\nat = 0.3\nset = {{ \"floor.patches\" = [{{ polygon = [[-9, -9], [9, -9], [9, 9], [-9, 9]], friction = 0.2 }}] }}
        [[event]]\nat = 0.4\nset = {{ \"floor.patches\" = [] }}"
    );
    let m = run(&text);
    let slower = 0.2 * G * 0.1;
    assert!((m.final_base_velocity[0] - (1.0 - slower)).abs() < 1e-10, "{:?}", m.final_base_velocity);
    assert!((m.final_base_position[0] - (1.0 - slower * (0.05 + 0.6))).abs() < 1e-10, "{:?}", m.final_base_position);
}

#[test]
fn payload_and_gravity_change_the_floor_force() {
    let text = |more: &str| {
        format!(
            "duration = 0.6\n{TIGHT}\n[robot]\n{BLOCK}
            [[event]]\nat = 0.2\nset = {{ \"robot.payload\" = [{{ link = \"block\", mass = 2.0, position = [0.02, 0, 0.1] }}] }}\n{more}"
        )
    };
    let m = run(&text(""));
    // Rounding of a static solve.
    assert!((m.final_normal_force_n.unwrap() - 3.0 * G).abs() < 1e-12);
    assert!(m.energy_error_j.abs() < 1e-12, "{}", m.energy_error_j);
    // The payload adds its potential energy: block and load together at 0.05 m and 0.15 m.
    assert!((m.external_work_j - 2.0 * G * 0.15).abs() < 1e-12, "{}", m.external_work_j);
    assert_eq!((m.state_changes, m.impacts), (0, 0));
    let more = "[[event]]\nat = 0.4\nset = { gravity = [0, 0, -5], \"robot.payload.0.mass\" = 3 }";
    let m = run(&text(more));
    assert!((m.final_normal_force_n.unwrap() - 20.0).abs() < 1e-12);
    assert!((m.final_com_position[2] - (0.05 + 0.1 * 0.75)).abs() < 1e-12, "{:?}", m.final_com_position);
    assert!(m.energy_error_j.abs() < 1e-12);
}

#[test]
fn gains_change_the_equilibrium_of_a_pendulum() {
    // Mass 1 kg and half length 0.25 m each; angles from hanging straight down.
    let settle = |events: &str| {
        let mut sim = simulation(&format!(
            "duration = 30
            integrator = {{ relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }}
            [robot]
            model = \"robots/pendulum/pendulum.urdf\"
            posture = {{ shoulder = 1.0, elbow = 0.5 }}
            joint_default = {{ mode = \"position\", kp = 40, kd = 6 }}
            {events}"
        ));
        finish(&mut sim, &mut NullObserver);
        let q = &sim.plant().state.joints;
        (q[0], q[1])
    };
    let load = |(shoulder, elbow): (f64, f64)| {
        let lower = 0.25 * G * (shoulder + elbow).sin();
        (0.75 * G * shoulder.sin() + lower, lower)
    };
    for (events, (kp_shoulder, kp_elbow)) in [
        ("", (40.0, 40.0)),
        ("[[event]]\nat = 10\nset = { \"robot.joint.shoulder.kp\" = 15 }", (15.0, 40.0)),
        // Changing one gain keeps the other.
        ("[[event]]\nat = 10\nset = { \"robot.joint.shoulder.kd\" = 5 }", (40.0, 40.0)),
        ("[[event]]\nat = 10\nset = { \"robot.joint_default.kp\" = 20, \"robot.joint.elbow.kp\" = 9.5 }", (20.0, 9.5)),
    ] {
        let at = settle(events);
        let (shoulder, elbow) = load(at);
        // Twenty seconds of the slowest mode, 6/9.5 s, leave e^-30; the integrator's tolerance
        // dominates.
        assert!((kp_shoulder * (1.0 - at.0) - shoulder).abs() < 1e-8, "{events}: {at:?}");
        assert!((kp_elbow * (0.5 - at.1) - elbow).abs() < 1e-8, "{events}: {at:?}");
    }
}

#[test]
fn joint_friction_can_change() {
    // With gravity off a pendulum rotates without end, until its joint is damped.
    let mut sim = simulation(
        "duration = 5\ngravity = [0, 0, 0]
        [robot]
        model = \"robots/pendulum/pendulum.urdf\"
        velocity = { shoulder = 1.0 }
        joint_default = { mode = \"passive\" }
        joint = { elbow = { mode = \"position\", kp = 500, kd = 50 }, shoulder = { friction = { viscous = 0.0 } } }
        [[event]]\nat = 1\nset = { \"robot.joint.shoulder.friction\" = { viscous = 0.1 } }",
    );
    finish(&mut sim, &mut NullObserver);
    // Both bars rotate as one: inertia 2 (I + m c^2) + m l^2 + 2 m l c about the shoulder, decay
    // from t = 1.
    let inertia = 2.0 * (0.2504 / 12.0 + 0.0625) + 0.25 + 0.25;
    let expected = (-0.1 * 4.0f64 / inertia).exp();
    let speed = sim.plant().state.v[0];
    // The default tolerance of 1e-6, and an elbow that yields while the shoulder slows down.
    assert!((speed - expected).abs() < 1e-4, "{speed} {expected}");
}

#[test]
fn a_force_changes_and_others_continue() {
    let text = format!(
        "duration = 1.0\nfloor = {{ friction = 0 }}\n{TIGHT}
        [robot]\n{BLOCK}
        [[force]]\ntype = \"constant\"\nlink = \"block\"\nforce = [0.5, 0, 0]
        [[force]]\ntype = \"push\"\nlink = \"block\"\nforce = [0, 0.4, 0]\nstart = 0.2\nduration = 0.6
        [[event]]\nat = 0.5\nset = {{ \"force.0.force\" = [1.5, 0, 0] }}
        [[event]]\nat = 0.75\nset = {{ \"force.0.force.0\" = -1 }}"
    );
    let m = run(&text);
    assert!((m.final_base_velocity[0] - (0.25 + 0.375 - 0.25)).abs() < 1e-10, "{:?}", m.final_base_velocity);
    assert!((m.final_base_velocity[1] - 0.24).abs() < 1e-10, "{:?}", m.final_base_velocity);
    assert!(m.energy_error_j.abs() < 1e-10);
}

#[test]
fn a_restored_flight_repeats_to_the_last_bit() {
    for integrator in [
        "{ relative_tolerance = 1e-8 }",
        "{ method = \"bs23\" }",
        "{ method = \"rk4\", step = 0.0009765625 }",
        "{ method = \"semi-implicit\", step = 0.0009765625 }",
    ] {
        let fly = |duration: f64, more: &str| {
            let mut sim = simulation(&format!(
                "duration = {duration}\nintegrator = {integrator}
                [robot]\n{BLOCK}\nsoles = []
                base = {{ position = [0, 0, 3], linear_velocity = [1, 0.2, 2], angular_velocity = [3, -2, 1] }}
                [[event]]\nat = 0.25\nsave = \"thrown\"\n{more}"
            ));
            let m = finish(&mut sim, &mut NullObserver);
            (sim.plant().state.clone(), m)
        };
        let (once, _) = fly(0.5, "");
        let (again, m) = fly(1.0, "[[event]]\nat = 0.75\nrestore = \"thrown\"");
        assert_eq!(again.time, 1.0);
        if integrator.contains("step") {
            let flight = |s: &State| (s.position, s.rotation, s.v.clone());
            assert_eq!(flight(&once), flight(&again), "{integrator}");
        }
        // All steps of dopri5 have the maximum length here, rounded by their start time. The errors
        // and the preceding steps determine those of bs23, so they differ: its tolerance per step
        // is 1e-6 of 3 rad/s.
        let bar = if integrator.contains("bs23") { 1e-6 } else { 1e-14 };
        let apart = (once.position - again.position).norm() + (once.rotation.coords - again.rotation.coords).norm();
        let faster = once.v.iter().zip(&again.v).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < bar && faster < bar, "{integrator}: {apart:e} {faster:e}");
        // A flight conserves its energy, except for the loss of first-order fixed steps.
        assert!(m.external_work_j.abs() < 0.1 && m.energy_error_j.abs() < 0.1, "{integrator}: {m:?}");
    }
}

#[test]
fn a_new_payload_does_not_move_the_carried_object() {
    // 1 kg of block; 0.5 kg of payload that becomes 1 kg while 0.25 kg are carried; a force that
    // follows them in the file.
    let text = |duration: f64| {
        format!(
            "duration = {duration}\n[robot]\n{BLOCK}\npayload = [{{ link = \"block\", mass = 0.5 }}]
            [[force]]\ntype = \"carried-object\"\nlink = \"block\"\nmass = 0.25\nstart = 0.1\nduration = 0.5
            [[force]]\ntype = \"constant\"\nlink = \"block\"\nforce = [0, 0, -1]
            [[event]]\nat = 0.3\nset = {{ \"robot.payload.0.mass\" = 1.0 }}
            [[event]]\nat = 0.4\nset = {{ \"force.1.force\" = [0, 0, -2] }}"
        )
    };
    for (duration, mass, force) in
        [(0.05, 1.5, 1.0), (0.2, 1.75, 1.0), (0.35, 2.25, 1.0), (0.5, 2.25, 2.0), (0.7, 2.0, 2.0)]
    {
        let normal = run(&text(duration)).final_normal_force_n.expect("it stands");
        // Rounding of a block at rest.
        assert!((normal - 9.81 * mass - force).abs() < 1e-11, "{duration}: {normal}");
    }
}

#[test]
fn a_restored_slide_slides_again() {
    let text = format!(
        "duration = 2.0\nfloor = {{ friction = 0.5 }}\n{TIGHT}
        [robot]\n{BLOCK}\nbase = {{ linear_velocity = [1, 0, 0] }}
        [[event]]\nat = 0.0\nsave = \"start\"
        [[event]]\nat = 0.1\nsave = \"sliding\"
        [[event]]\nat = 0.5\nrestore = \"sliding\"
        [[event]]\nat = 1.5\nrestore = \"start\"
        [[event]]\nat = 1.6\nrestore = \"sliding\""
    );
    let (m, recording) = watch(&text);
    let way = 1.0 / (2.0 * 0.5 * G);
    assert!((m.final_base_position[0] - way).abs() < 1e-9, "{:?}", m.final_base_position);
    let sticks: Vec<f64> = recording.events.iter().filter(|e| e.kind == "stick").map(|e| e.time).collect();
    let rest = 1.0 / (0.5 * G);
    // Event location at 1e-13 of a step, and speeds below 1e-10 m/s that count as rest.
    assert_eq!(sticks.len(), 3, "{sticks:?}");
    for (found, expected) in sticks.iter().zip([rest, 0.4 + rest, 1.5 + rest]) {
        assert!((found - expected).abs() < 1e-9, "{sticks:?}");
    }
    assert_eq!((m.impacts, m.inconsistent), (0, 0));
    assert!(m.energy_error_j.abs() < 1e-9);
    let other: Vec<_> = recording.events.iter().filter(|e| !["event", "stick"].contains(&e.kind.as_str())).collect();
    assert!(other.is_empty(), "{other:?}");
}

#[test]
fn events_at_the_start_apply_from_the_start() {
    let ice =
        |how: &str| run(&format!("duration = 0.5\n{TIGHT}\n[robot]\n{BLOCK}\nbase = {{ rpy = [0, 0.2, 0] }}\n{how}"));
    let from_start = ice("[floor]\nfriction = 0.1\nrpy = [0, 0.2, 0]");
    let by_event = ice("[floor]\nrpy = [0, 0.2, 0]\n[[event]]\nat = 0\nset = { \"floor.friction\" = 0.1 }");
    assert_eq!(from_start.final_base_position, by_event.final_base_position);
    assert!(from_start.final_base_shift_m > 0.1);
}

/// A sliding state restored slides again, whatever the state before the restore: standing, or
/// sliding the other way.
#[test]
fn a_saved_slide_continues() {
    for how in [
        "contact = { method = \"one-step\" }\nintegrator = { method = \"semi-implicit\", step = 1e-3 }",
        "contact = { method = \"one-step\" }",
        "contact = { method = \"exact\" }\nintegrator = { method = \"semi-implicit\", step = 1e-3 }",
        "contact = { method = \"exact\" }",
    ] {
        for between in [
            "",
            "[[force]]\ntype = \"push\"\nlink = \"block\"\npoint = [0, 0, -0.05]\nforce = [-30, 0, 0]\nstart = 0.4\nduration = 0.2",
        ] {
            let text = format!(
                "duration = 1.4\nfloor = {{ friction = 0.5 }}\n{how}
                [robot]\n{BLOCK}\nbase = {{ linear_velocity = [2, 0, 0] }}
                {between}
                [[event]]\nat = 0.1\nsave = \"slide\"
                [[event]]\nat = 0.6\nrestore = \"slide\""
            );
            let m = run(&text);
            let way = 2.0 * 2.0 / (2.0 * 0.5 * G);
            // First order in steps of 1e-3 s at 2 m/s, or a stop decided a step late; otherwise the
            // integrator's tolerance.
            let allowed = if how.contains("semi") || how.contains("one-step") { 2.5e-3 } else { 1e-6 };
            assert!((m.final_base_position[0] - way).abs() < allowed, "{how} {between}: {}", m.final_base_position[0]);
        }
    }
}
