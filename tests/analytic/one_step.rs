//! The one-step method against the exact one, through slip, tipping and rocking.

use crate::support::runs::run;
use stiction::sim::Metrics;

/// HOAP-2 pushed forwards and sideways: both feet rotate on the floor, tip and land again.
fn pushed(method: &str, step: f64) -> Metrics {
    run(&format!(
        "duration = 0.6
        robot = {{ model = \"robots/hoap2/hoap2.toml\" }}
        contact = {{ method = \"{method}\", distance_tolerance = 1e-5, velocity_tolerance = 1e-4 }}
        integrator = {{ method = \"semi-implicit\", step = {step} }}
        [[force]]
        type = \"push\"
        link = \"torso\"
        point = [0, 0, 0.05]
        force = [20, 10, 0]
        start = 0.1
        duration = 0.1
        profile = \"half-sine\"\n"
    ))
}

#[test]
fn one_step_follows_the_exact_method_through_a_push() {
    let step = 1e-4;
    let (exact, fast) = (pushed("exact", step), pushed("one-step", step));
    // It decides by the last load, so it reacts a step late. The right foot tips over its edge
    // first and slips in the same step, which makes two.
    let late = fast.first_slip_s.expect("it slips") - exact.first_slip_s.expect("it slips");
    assert!((1.5 * step..2.5 * step).contains(&late), "{late}");
    // The rotation of the robot is the sum of its slips and pivots. The landing feet pull for a
    // step, which loses some of it: 2 % were measured.
    let (turn, truth) = (fast.final_base_rpy[2], exact.final_base_rpy[2]);
    assert!(truth > 5e-3 && (turn / truth - 1.0).abs() < 0.05, "{turn} {truth}");
    // One candidate a selection, never a search.
    assert_eq!(fast.states_tested, fast.selections);
    assert_eq!(fast.states_tested_max, 1);
}
