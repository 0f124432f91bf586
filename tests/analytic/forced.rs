//! States imposed on a sole: they hold from and to their instants, and the residuals report the
//! violations.

use super::body::{Body, G};
use crate::support::runs::watch;
use stiction::scenario;
use stiction::sim::{Metrics, SimEvent};

fn imposed(state: &str, from: f64, to: f64, floor: &str, base: &str, duration: f64) -> (Metrics, Vec<SimEvent>) {
    let (m, recording) = watch(&format!(
        "duration = {duration}
        floor = {{ {floor} }}
        robot = {{ model = \"robots/block/block.toml\", base = {{ {base} }} }}
        integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
        [contact]
        distance_tolerance = 1e-8
        velocity_tolerance = 1e-8
        acceleration_tolerance = 1e-8
        forced = [{{ sole = \"bottom\", state = \"{state}\", from = {from}, to = {to} }}]\n"
    ));
    // An imposed state does not count as a failed selection.
    assert_eq!((m.inconsistent, m.jams), (0, 0), "{state}");
    (m, recording.events)
}

fn times(events: &[SimEvent], kind: &str) -> Vec<f64> {
    events.iter().filter(|e| e.kind == kind).map(|e| e.time).collect()
}

#[test]
fn a_face_held_on_ice_beyond_the_friction_angle_slides_from_its_release() {
    let (mu, angle) = (0.2, 20f64.to_radians());
    let slope = format!("friction = {mu}, rpy = [0, {angle}, 0]");
    // Until 0.437 s, which is not an end of a step or a tick.
    let (m, events) = imposed("face-static", 0.0, 0.437, &slope, &format!("rpy = [0, {angle}, 0]"), 1.0);
    let excess = G * (angle.sin() - mu * angle.cos());
    let way = 0.5 * excess * (1.0 - 0.437f64).powi(2);
    // A parabola, exact for the integrator; rounding.
    assert!((m.final_base_position[0] / angle.cos() - way).abs() < 1e-12, "{}", m.final_base_position[0]);
    // During the imposed state, friction carried more than its law allows: 1 kg.
    assert!((m.max_cone_excess - excess).abs() < 1e-9, "{} {excess}", m.max_cone_excess);
    assert!(m.max_static_creep_m < 1e-12);
    assert_eq!((times(&events, "slip"), m.first_slip_s), (vec![0.437], Some(0.437)));
    assert_eq!(times(&events, "forced"), [0.0, 0.437]);
}

#[test]
fn a_sole_without_contact_falls_through_the_floor_and_stops_at_its_release() {
    let (m, events) = imposed("free", 0.2, 0.3, "friction = 0.5", "", 0.6);
    let depth = 0.5 * G * 0.1 * 0.1;
    assert!((m.max_penetration_m - depth).abs() < 1e-12, "{}", m.max_penetration_m);
    assert!((m.final_base_position[2] - (0.05 - depth)).abs() < 1e-12);
    assert_eq!((times(&events, "liftoff"), times(&events, "touchdown")), (vec![0.2], vec![0.3]));
    assert_eq!(m.impacts, 1);
    assert!(m.energy_error_j.abs() < 1e-12, "the impact is accounted for: {}", m.energy_error_j);
}

#[test]
fn impossible_states_are_imposed() {
    // A face clamped a metre up in the air stops the fall at once.
    let (m, events) = imposed("face-static", 0.2, 0.3, "friction = 0.5", "position = [0, 0, 1.05]", 0.4);
    let (fallen, again) = (0.5 * G * 0.04, 0.5 * G * 0.01);
    assert!((m.final_base_position[2] - (1.05 - fallen - again)).abs() < 1e-12, "{}", m.final_base_position[2]);
    assert_eq!((times(&events, "touchdown"), times(&events, "liftoff")), (vec![0.2], vec![0.3]));
    // An imposed static state stops a sliding block, which stays at rest afterwards.
    let (m, events) = imposed("face-static", 0.2, 0.3, "friction = 0.2", "linear_velocity = [1, 0, 0]", 0.4);
    assert!((m.final_base_position[0] - (0.2 - 0.5 * 0.2 * G * 0.04)).abs() < 1e-12, "{}", m.final_base_position[0]);
    assert_eq!(times(&events, "stick"), [0.2]);
    assert!(m.energy_error_j.abs() < 1e-12);
    // One edge alone cannot carry the block: it rotates about it through the floor, as a pendulum
    // does.
    let (m, _) = imposed("edge-0-static", 0.2, 0.25, "friction = 9.0", "", 0.25);
    let tilt = m.final_base_rpy[0].abs();
    let rate = m.max_penetration_m;
    assert!(tilt > 0.01 && rate > 0.001, "{tilt} {rate}");
}

#[test]
fn an_imposed_slide_has_kinetic_friction() {
    // Static friction would hold the push of 3 N; imposed sliding lets it win against the kinetic one.
    let text = "
        duration = 0.4
        floor = { friction = { static = 0.8, kinetic = 0.1 } }
        robot = { model = \"robots/block/block.toml\" }
        contact = { forced = [{ sole = \"bottom\", state = \"face-dynamic\", from = 0.1, to = 0.3 }] }
        integrator = { relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }
        [[force]]
        type = \"constant\"
        link = \"block\"
        force = [3.0, 0.0, 0.0]\n";
    let (m, recording) = watch(text);
    let a = 3.0 - 0.1 * G;
    // Once it moves it continues without the imposed state.
    assert!(
        (m.final_base_position[0] - 0.5 * a * 0.09).abs() < 1e-10,
        "{} {}",
        m.final_base_position[0],
        0.5 * a * 0.09
    );
    assert_eq!((m.first_slip_s, m.inconsistent), (Some(0.1), 0));
    assert_eq!(times(&recording.events, "forced"), [0.1, 0.3]);
}

#[test]
fn fixed_steps_hold_imposed_states_from_and_to_their_instants() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    for method in ["exact", "one-step"] {
        let (m, recording) = watch(&format!(
            "duration = 0.6
            floor = {{ friction = 0.5 }}
            {}
            contact = {{ method = \"{method}\", forced = [{{ sole = \"bottom\", state = \"free\", from = 0.2005, to = 0.3005 }}] }}
            integrator = {{ method = \"semi-implicit\", step = 1e-3 }}\n",
            body.robot("")
        ));
        // Euler's fall of n steps is n (n + 1) g dt^2 / 2.
        let depth = 0.5 * G * 0.1 * 0.101;
        assert!((m.max_penetration_m - depth).abs() < 1e-9, "{method} {} {depth}", m.max_penetration_m);
        assert_eq!(m.inconsistent, 0, "{method}");
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let (up, down) = (m.first_liftoff_s.expect("let go"), m.first_touchdown_s.expect("caught"));
        assert!(near(up, 0.2005) && near(down, 0.3005), "{method} {up} {down}");
        assert_eq!(times(&recording.events, "forced").len(), 2);
    }
}

#[test]
fn a_sole_or_a_state_that_does_not_exist_is_refused() {
    for (sole, state, message) in
        [("top", "free", "has no sole `top`"), ("bottom", "edge-4-static", "has no state `edge-4-static`")]
    {
        let text = format!(
            "robot = {{ model = \"robots/block/block.toml\" }}
            contact = {{ forced = [{{ sole = \"{sole}\", state = \"{state}\" }}] }}\n"
        );
        let runs = scenario::parse(std::path::Path::new("t.toml"), &text).unwrap().expand(&[]).unwrap();
        let robot = stiction::robot::load(&crate::support::runs::root().join("robots/block/block.toml")).unwrap();
        let errors = stiction::assemble::setup(&runs[0], &robot).err().expect("refused").to_string();
        assert!(errors.contains(message) && errors.contains("t.toml:2"), "{errors}");
    }
}

#[test]
fn an_imposed_slide_decelerates_with_one_step_and_every_integrator() {
    let (mu, speed) = (0.5, 1.0);
    let stop = speed / (mu * G);
    for integrator in
        ["dopri5\", max_step = 1e-3", "bs23\", max_step = 1e-3", "rk4\", step = 1e-3", "semi-implicit\", step = 1e-3"]
    {
        let (m, _) = watch(&format!(
            "duration = {}
            floor = {{ friction = {mu} }}
            robot = {{ model = \"robots/block/block.toml\", base = {{ linear_velocity = [{speed}, 0, 0] }} }}
            integrator = {{ method = \"{integrator} }}
            contact = {{ method = \"one-step\", forced = [{{ sole = \"bottom\", state = \"face-dynamic\" }}] }}\n",
            2.0 * stop
        ));
        // Directions are constant for a step of 1 ms: it stops one step late, or jitters within the
        // friction impulse of one step.
        assert!(m.final_base_velocity[0].abs() <= 2.0 * mu * G * 1e-3, "{integrator} {:?}", m.final_base_velocity);
        let way = speed * speed / (2.0 * mu * G);
        assert!(
            (m.final_base_position[0] - way).abs() < 2.0 * speed * 1e-3,
            "{integrator} {:?}",
            m.final_base_position
        );
        assert!(m.friction_loss_j > 0.0, "{integrator} {}", m.friction_loss_j);
    }
}
