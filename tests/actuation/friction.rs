//! Friction in joints: the law, creep under load, and absence of chatter.

use super::{NO_COMMANDS, simulation, wheel};
use crate::support::runs::{Recording, finish, rk4};
use stiction::sim::NullObserver;

fn spinning(settings: &str, friction: &str, start: f64) -> String {
    format!(
        "duration = 1.0
        gravity = [0, 0, 0]
        log = {{ rate = 1000.0 }}
        {settings}
        [robot]
        model = \"given\"
        soles = []
        joint = {{ axle = {{ mode = \"force\"{friction} }} }}
        velocity = {{ axle = {start} }}\n"
    )
}

const LAW: &str = "{ coulomb = 0.4, viscous = 0.05, static = 0.9, stribeck_velocity = 0.3, slip_velocity = 0.02 }";

#[test]
fn a_wheel_decelerates_by_the_friction_law() {
    let inertia = 0.2;
    let slowing = |_: f64, [v]: &[f64; 1]| {
        let dry = 0.4 + 0.5 * (-(v / 0.3) * (v / 0.3)).exp();
        [-(dry * (v / 0.02).tanh() + 0.05 * v) / inertia]
    };
    let tight = "integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }";
    for (start, t) in [(1.5, 0.3), (-1.5, 0.5), (0.3, 0.2)] {
        let text = spinning(tight, &format!(", friction = {LAW}"), start)
            .replace("duration = 1.0", &format!("duration = {t}"));
        let mut sim = simulation(Some(&wheel(inertia)), &text, NO_COMMANDS);
        let metrics = finish(&mut sim, &mut NullObserver);
        let [truth] = rk4([start], t, 100_000, slowing);
        // Error control at 1e-10 over some hundred steps.
        assert!((sim.plant().state.v[0] - truth).abs() < 1e-8, "{} {truth}", sim.plant().state.v[0]);
        let lost = 0.5 * inertia * (start * start - truth * truth);
        assert!((metrics.joint_loss_j - lost).abs() < 1e-8 && metrics.max_energy_error_j < 1e-8, "{metrics:?}");
        // The force model of the same law gives the same motion; its loss is negative external
        // work.
        let text = spinning(tight, "", start).replace("duration = 1.0", &format!("duration = {t}"));
        let text = format!("{text}[[force]]\ntype = \"joint-friction\"\njoints = {{ axle = {LAW} }}\n");
        let mut sim = simulation(Some(&wheel(inertia)), &text, NO_COMMANDS);
        let metrics = finish(&mut sim, &mut NullObserver);
        assert!((sim.plant().state.v[0] - truth).abs() < 1e-8);
        assert!((metrics.external_work_j + lost).abs() < 1e-8, "{metrics:?}");
    }
}

#[test]
fn a_loaded_joint_creeps_at_the_inverse_hyperbolic_tangent() {
    let creep = 0.05 * 0.5f64.atanh();
    for settings in [
        "integrator = { relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }",
        "integrator = { method = \"semi-implicit\", step = 1e-3 }",
    ] {
        let text = spinning(settings, ", friction = { coulomb = 2.0 }", 0.0);
        let mut sim = simulation(Some(&wheel(0.01)), &text, Some(|_, _| [0.0, 0.0, 1.0]));
        finish(&mut sim, &mut NullObserver);
        // At 300/s the approach has ended; both end in the same balance of efforts.
        assert!((sim.plant().state.v[0] - creep).abs() < 1e-9, "{settings} {}", sim.plant().state.v[0]);
    }
}

#[test]
fn static_friction_holds_a_load_beyond_coulomb_friction() {
    let friction = ", friction = { coulomb = 1.0, static = 1.5, stribeck_velocity = 0.5, slip_velocity = 1e-3 }";
    let end = |load: f64| {
        let text = spinning("", friction, 0.0);
        let mut sim = simulation(Some(&wheel(0.1)), &text, Some(move |_, _| [0.0, 0.0, load]));
        finish(&mut sim, &mut NullObserver);
        sim.plant().state.v[0]
    };
    // A load of 1.4 of 1.5 creeps at v_s atanh(1.4 / 1.5); 1.6 breaks away and ends near (1.6 - 1)
    // / 0.1 per second.
    assert!((end(1.4) - 1e-3 * (1.4f64 / 1.5).atanh()).abs() < 1e-6, "{}", end(1.4));
    assert!(end(1.6) > 3.0, "{}", end(1.6));
}

#[test]
fn strong_friction_on_a_small_inertia_does_not_chatter() {
    // The friction impulse of a step, c dt = 1e-3, is ten times what stops the wheel, and 2e4 times
    // what the slip speed allows for explicit steps.
    let law = "{ coulomb = 1.0, static = 1.3, slip_velocity = 0.005 }";
    let settings = "integrator = { method = \"semi-implicit\", step = 1e-3 }";
    let model = spinning(settings, &format!(", friction = {law}"), 1.0);
    let force = format!("{}[[force]]\ntype = \"joint-friction\"\nall = {law}\n", spinning(settings, "", 1.0));
    for text in [model, force] {
        let mut sim = simulation(Some(&wheel(1e-5)), &text, NO_COMMANDS);
        let mut recording = Recording::default();
        let metrics = finish(&mut sim, &mut recording);
        assert!(recording.snapshots.windows(2).all(|w| w[1].qd[0] >= 0.0 && w[1].qd[0] <= w[0].qd[0]), "monotonous");
        assert!(sim.plant().state.v[0] < 1e-9, "{}", sim.plant().state.v[0]);
        // Friction dissipates all of the energy and supplies none.
        assert!((metrics.joint_loss_j - metrics.external_work_j - 0.5e-5).abs() < 1e-17, "{metrics:?}");
    }
}

#[test]
fn a_standing_robot_with_dry_joints_has_no_events_and_few_steps() {
    let text = |friction: &str, settings: &str| {
        format!(
            "duration = 1.0
            {settings}
            robot = {{ model = \"robots/hoap2/hoap2.toml\" }}
            [[task]]
            type = \"posture\"
            duration = 0.4
            joints = {{ left_shoulder_roll = 0.3 }}
            {friction}\n"
        )
    };
    let dry = "[[force]]\ntype = \"joint-friction\"\nall = { coulomb = 0.5, static = 0.8, viscous = 0.01 }";
    // Explicit steps have to follow the slope s / (v_s I) of the hands (6e-4 kg m^2): 1000/s.
    let mild = "[[force]]\ntype = \"joint-friction\"\nall = { coulomb = 0.02, static = 0.03, viscous = 0.01 }";
    let run = |friction: &str, settings: &str| {
        let mut sim = simulation(None, &text(friction, settings), NO_COMMANDS);
        let mut recording = Recording::default();
        (finish(&mut sim, &mut recording), recording)
    };
    let ((free, _), (rough, recording)) = (run("", ""), run(mild, ""));
    assert_eq!((rough.events, rough.state_changes, rough.inconsistent), (0, 0, 0), "{rough:?}");
    assert!(rough.evaluations < 2 * free.evaluations, "{} {}", rough.evaluations, free.evaluations);
    // At the end it rests: no joint moves faster than its creep under the servo.
    let last = recording.snapshots.last().expect("one");
    assert!(last.qd.iter().all(|v| v.abs() < 5e-3), "{:?}", last.qd);
    // Velocity-level steps: the sign of a joint's velocity does not alternate from snapshot to snapshot.
    let (_, recording) = run(dry, "integrator = { method = \"semi-implicit\", step = 1e-3 }\nlog = { rate = 1000.0 }");
    for j in 0..recording.snapshots[0].qd.len() {
        let moving = |v: f64| v.abs() > 1e-6;
        let turns =
            recording.snapshots.windows(2).filter(|w| w[0].qd[j] * w[1].qd[j] < 0.0 && moving(w[0].qd[j])).count();
        assert!(turns < 20, "joint {j} turns {turns} times");
    }
}
