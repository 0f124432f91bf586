//! The energy balance of a slide, a fall, a push and a swing.

use super::body::{Body, G};
use crate::support::runs::{TIGHT, run, watch};

fn base(body: &Body, height: f64, velocity: [f64; 3]) -> String {
    let z = body.half[2] + height;
    body.robot(&format!("position = [0.0, 0.0, {z}], linear_velocity = {velocity:?}"))
}

#[test]
fn friction_dissipates_all_energy_of_a_slide() {
    for (body, mu) in Body::several().into_iter().zip([0.5, 0.1, 0.6, 0.3]) {
        let (vx, vy) = (1.2, -0.5);
        let truth = 0.5 * body.mass * (vx * vx + vy * vy);
        let text = format!("duration = 1.8\nfloor = {{ friction = {mu} }}\n{}", base(&body, 0.0, [vx, vy, 0.0]));
        let m = run(&format!("{text}{TIGHT}"));
        let [x, y, _] = m.final_base_position;
        let way = x.hypot(y);
        // Forces are constant, powers linear in time: only rounding, and the event that ends the
        // slide, to 1e-13 of a step.
        assert!((m.friction_loss_j / truth - 1.0).abs() < 1e-12, "{m:?}");
        assert!((m.friction_loss_j / (mu * body.mass * G * way) - 1.0).abs() < 1e-12, "{m:?}");
        assert!((m.energy_change_j / truth + 1.0).abs() < 1e-12 && m.impact_loss_j.abs() < 1e-12 * truth);
        assert_eq!((m.actuator_work_j, m.external_work_j, m.joint_loss_j), (0.0, 0.0, 0.0));
        assert!(m.max_energy_error_j < 1e-12 * truth, "at no time was it worse: {m:?}");
        assert!(m.max_dissipation_gap_w < 1e-9 * mu * body.mass * G && m.max_cone_excess < 1e-12 * body.mass * G);

        // Steps of dt, the last one ended by sticking: friction still dissipates all energy, and
        // the distance errs by v dt / 2.
        let dt = 1e-3;
        let m = run(&format!("{text}integrator = {{ method = \"semi-implicit\", step = {dt} }}"));
        assert!((m.friction_loss_j / truth - 1.0).abs() < 1e-12, "{m:?}");
        let [x, y, _] = m.final_base_position;
        let way = x.hypot(y);
        let size = mu * body.mass * G;
        assert!((m.friction_loss_j - size * way).abs() < 0.6 * dt * 1.3 * size, "{m:?}");
    }
}

#[test]
fn a_flat_fall_loses_its_energy_in_the_impact() {
    for (body, height) in Body::several().into_iter().zip([0.3, 0.05, 1.0, 0.2]) {
        let duration = (2.0 * height / G).sqrt() + 0.1;
        let truth = body.mass * G * height;
        let m = run(&format!("duration = {duration}\n{}{TIGHT}", base(&body, height, [0.0; 3])));
        // Free fall is a parabola, exact for the integrator.
        assert!((m.impact_loss_j / truth - 1.0).abs() < 1e-12, "{m:?}");
        assert!((m.energy_change_j / truth + 1.0).abs() < 1e-12 && m.friction_loss_j.abs() < 1e-15 * truth);
        assert!(m.max_energy_error_j < 1e-12 * truth, "{m:?}");
        let fixed = "integrator = { method = \"semi-implicit\", step = 1e-3 }";
        let m = run(&format!("duration = {duration}\n{}{fixed}", base(&body, height, [0.0; 3])));
        // Falling with v(t + dt) loses m g^2 dt t / 2 of the energy, which is the error; the impact
        // dissipates the rest.
        let error = 0.5 * body.mass * G * 1e-3 * (2.0 * height * G).sqrt();
        assert!((m.impact_loss_j - truth).abs() < 2.5 * error && m.energy_error_j.abs() < 2.5 * error, "{m:?}");
    }
}

#[test]
fn the_work_of_a_push_is_force_times_distance() {
    // F = 3 mu m g over 0.2 s, from rest: a = 2 mu g, distance a t^2 / 2, work F times that.
    let body = Body::new([0.1, 0.1, 0.005], 1.0);
    let mu = 0.2;
    let force = 3.0 * mu * body.mass * G;
    let text = format!(
        "duration = 1.5\nfloor = {{ friction = {mu} }}\n{}
        {TIGHT}
        [[force]]
        type = \"push\"
        link = \"block\"
        force = [0.0, {force}, 0.0]
        start = 0.1
        duration = 0.2
        profile = \"constant\"\n",
        base(&body, 0.0, [0.0; 3])
    );
    let m = run(&text);
    // The force jumps beyond the capacity, so the slip begins at the jump.
    assert_eq!(m.first_slip_s, Some(0.1));
    let work = force * 0.5 * (2.0 * mu * G) * 0.2 * 0.2;
    // The slip begins and ends at events, located to 1e-13 of a step.
    assert!((m.external_work_j / work - 1.0).abs() < 1e-10, "{} {work}", m.external_work_j);
    assert!((m.friction_loss_j / work - 1.0).abs() < 1e-10 && m.energy_change_j.abs() < 1e-10 * work, "{m:?}");
    assert!(m.max_energy_error_j < 1e-10 * work, "{m:?}");
}

/// HOAP-2 dropped from `height` above standing and pushed, with damped joints.
fn pushed(height: f64, force: [f64; 2], mu: f64, settings: &str) -> String {
    let (z, [x, y]) = (0.284 + height, force);
    format!(
        "duration = 0.8
        robot = {{ model = \"robots/hoap2/hoap2.toml\", base = {{ position = [0.0, 0.0, {z}] }} }}
        floor = {{ friction = {mu} }}
        {settings}
        [[force]]
        type = \"push\"
        link = \"torso\"
        point = [0.0, 0.0, 0.05]
        force = [{x}, {y}, 0.0]
        start = 0.2
        duration = 0.15
        profile = \"half-sine\"
        [[force]]
        type = \"joint-friction\"
        all = {{ viscous = 0.02 }}\n"
    )
}

#[test]
fn the_balance_of_a_pushed_robot_closes_to_the_integration_error() {
    let tolerance = |t: f64| format!("integrator = {{ relative_tolerance = {t}, absolute_tolerance = {} }}", 0.01 * t);
    let mut errors = vec![];
    for t in [1e-6, 1e-9] {
        let (m, recording) = watch(&pushed(0.03, [24.0, 6.0], 0.3, &tolerance(t)));
        println!("{t:e}: {m:?}");
        let flow = m.actuator_work_j.abs() + m.external_work_j.abs() + m.impact_loss_j + m.friction_loss_j;
        assert!(m.external_work_j.abs() > 0.05 && m.impact_loss_j > 0.05 && m.friction_loss_j > 1e-4, "{m:?}");
        assert!(m.impacts > 0 && flow > 0.2, "something happened");
        let parts = m.actuator_work_j + m.external_work_j - m.joint_loss_j - m.friction_loss_j - m.impact_loss_j;
        assert!((m.energy_change_j - parts - m.energy_error_j).abs() < 1e-13);
        assert!(m.max_energy_error_j >= m.energy_error_j.abs() && m.rms_energy_error_j <= m.max_energy_error_j);
        // Losses never decrease; snapshots agree with the end.
        let mut before = (0.0, 0.0);
        for s in &recording.snapshots {
            let now = (s.energy.friction_loss, s.energy.impact_loss);
            assert!(now.0 >= before.0 - 1e-12 && now.1 >= before.1 - 1e-12, "{} s: {before:?} {now:?}", s.time);
            before = now;
        }
        let last = recording.snapshots.last().expect("there are some").energy;
        assert!((last.error() - m.energy_error_j).abs() < 1e-12 && last.external == m.external_work_j);
        errors.push(m.max_energy_error_j);
    }
    // Each of about twenty events may move a vertex onto the floor from 1e-10 m off it, under up to
    // 70 N. The integration error is small against that.
    assert!(errors.iter().all(|e| *e < 20.0 * 70.0 * 1e-10), "{errors:?}");
}

#[test]
fn with_fixed_steps_the_balance_is_of_first_order() {
    let settings = |dt: f64| format!("integrator = {{ method = \"semi-implicit\", step = {dt} }}");
    let fixed = |dt: f64| watch(&pushed(0.002, [8.0, 2.0], 0.8, &settings(dt)));
    let ((coarse, recording), (fine, _)) = (fixed(1e-3), fixed(1e-4));
    // The log has each instant once, including the end.
    assert!(recording.snapshots.windows(2).all(|w| w[0].time < w[1].time));
    assert_eq!(recording.snapshots.last().map(|s| (s.time, s.energy.error())), Some((0.8, coarse.energy_error_j)));
    println!("{coarse:?}\n{fine:?}");
    assert!(coarse.external_work_j > 1e-3 && coarse.impact_loss_j > 1e-2, "{coarse:?}");
    assert!(coarse.max_energy_error_j < 0.1 * coarse.impact_loss_j, "{coarse:?}");
    assert!(fine.max_energy_error_j < 0.2 * coarse.max_energy_error_j, "{coarse:?}\n{fine:?}");
}
