//! Figures of the summary that depend neither on the log nor on what other bodies do.

use super::body::{Body, G};
use crate::support::runs::run;

fn block() -> Body {
    Body::new([0.1, 0.1, 0.05], 1.0)
}

/// A body on springs is restored to its own rest: its floor force is there at once.
#[test]
fn a_restored_rest_on_springs_is_a_rest() {
    let (body, depth) = (block(), G / 4.0 / 2e4);
    for integrator in ["dopri5", "rosenbrock", "bdf"] {
        let text = format!(
            "duration = 0.3\n{}contact = {{ method = \"penalty\", penalty = {{ stiffness = 2e4, damping = 200 }} }}\n\
             integrator = {{ method = \"{integrator}\" }}\n\
             event = [{{ at = 0.1, save = \"rest\" }}, {{ at = 0.2, restore = \"rest\" }}]\n",
            body.robot(&format!("position = [0, 0, {}]", 0.05 - depth)),
        );
        let m = run(&text);
        assert_eq!(m.state_changes, 0, "{integrator}");
        // Rounding of a height of 0.05 m, times the weight.
        assert!(m.max_energy_error_j < 1e-13, "{integrator}: {:e} J", m.max_energy_error_j);
        // The springs' 8e4 N/m times the absolute tolerance, 1e-9 m.
        assert!((m.final_normal_force_n.unwrap() - G).abs() < 8e-5, "{integrator}: {:?}", m.final_normal_force_n);
    }
}

/// The force of the last step is a mean over it, however many instants a log has.
#[test]
fn forces_at_the_end_do_not_depend_on_the_log() {
    let body = block();
    for method in ["exact", "one-step", "penalty"] {
        let force = |rate: f64| {
            let text = format!(
                "duration = 0.202\nlog = {{ rate = {rate} }}\n{}contact = {{ method = \"{method}\" }}\n\
                 integrator = {{ method = \"semi-implicit\", step = 1e-3 }}\n",
                body.robot("position = [0, 0, 0.25]"),
            );
            run(&text).final_normal_force_n.unwrap()
        };
        let forces = [0.0, 50.0, 1000.0].map(force);
        assert!(forces[0] > 100.0 && forces.iter().all(|f| f.to_bits() == forces[0].to_bits()), "{method}: {forces:?}");
        if method == "exact" {
            // The fall of 201 steps is stopped in the next one; gaps close at most to the floor.
            let speed = 201.0 * 1e-3 * G;
            assert!(forces[0] <= (speed + 1e-3 * G) / 1e-3 + 1e-9, "{forces:?}");
        }
    }
}

/// A robot that flies over a floor on which a box rests, or has no sole.
#[test]
fn flights_and_lifts_are_those_of_the_robot() {
    let body = block();
    let object = "object = [{ type = \"box\", size = [0.2, 0.2, 0.2], mass = 3.0, position = [2, 0, 0.1] }]\n";
    for (method, integrator) in
        [("exact", "dopri5"), ("one-step", "dopri5"), ("penalty", "dopri5"), ("exact", "semi-implicit")]
    {
        let thrown = |robot: String| {
            let method =
                format!("contact = {{ method = \"{method}\" }}\nintegrator = {{ method = \"{integrator}\" }}\n");
            run(&format!("duration = 0.4\nlog = {{ rate = 0 }}\n{robot}{method}{object}"))
        };
        let m = thrown(body.robot("position = [0, 0, 3], linear_velocity = [0, 0, 2]"));
        // At the end of the step nearest to the top: steps of at most some 0.05 s, g dt^2 / 8 below it.
        let top = 3.0 - 0.05 + 2.0 * 2.0 / (2.0 * G);
        let lift = m.max_lift_m.unwrap();
        assert!((lift - top).abs() < 0.01, "{method} {integrator}: {lift} {top}");
        let drift = m.max_flight_path_drift_m.unwrap();
        if integrator == "semi-implicit" {
            // x_n = x_0 - g dt^2 n (n + 1) / 2, so g dt t / 2 from the parabola.
            let expected = 0.5 * G * 1e-3 * 0.4;
            assert!((drift / expected - 1.0).abs() < 1e-9, "{drift} {expected}");
        } else {
            // Rounding of some metres.
            assert!(drift < 1e-13, "{method}: {drift:e}");
        }
        let none = body.robot("position = [0, 0, 3]").replace("soles = [{", "soles = []}\n# [{");
        assert_eq!(thrown(none).max_lift_m, None, "{method} {integrator}");
    }
    let fixed = run("duration = 0.1\nrobot = { model = \"robots/pendulum/pendulum.urdf\" }\n");
    assert_eq!((fixed.max_flight_path_drift_m, fixed.max_flight_spin_drift_nms, fixed.max_lift_m), (None, None, None));
}

/// The centre of pressure is on the floor, however deep the springs are pressed into it.
#[test]
fn the_centre_of_pressure_of_a_rest_is_below_the_centre_of_mass() {
    let body = block();
    let text = format!(
        "duration = 0.2\n{}contact = {{ method = \"penalty\", penalty = {{ stiffness = 1e4, damping = 200 }} }}\n",
        body.robot(&format!("position = [0.3, 0.2, {}]", 0.05 - G / 4e4)),
    );
    let offset = run(&text).final_cop_offset_m.unwrap();
    // Rounding of positions of 0.3 m.
    assert!(offset < 1e-15, "{offset:e} m");
}
