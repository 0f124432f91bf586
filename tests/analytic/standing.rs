//! HOAP-2 on its feet, and the errors of the fixed-step method.

use super::body::G;
use crate::support::runs::{finish, run, simulation, watch};
use stiction::sim::NullObserver;

fn standing(method: &str, duration: f64, integrator: &str) -> String {
    format!(
        "duration = {duration}
        robot = {{ model = \"robots/hoap2/hoap2.toml\" }}
        contact = {{ method = \"{method}\", distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }}
        integrator = {{ {integrator} }}\n"
    )
}

const ADAPTIVE: &str = "relative_tolerance = 1e-9, absolute_tolerance = 1e-11";

#[test]
fn a_standing_humanoid_does_not_creep_and_the_floor_carries_its_weight() {
    let mut sim = simulation(&standing("exact", 10.0, ADAPTIVE));
    let (m, weight) = (finish(&mut sim, &mut NullObserver), sim.plant().model.mass() * G);
    assert!(m.max_static_creep_m < 1e-9, "{}", m.max_static_creep_m);
    assert_eq!((m.first_slip_s, m.first_liftoff_s, m.inconsistent), (None, None, 0));
    let (_, recording) = watch(&standing("exact", 10.0, ADAPTIVE));
    let end = recording.snapshots.last().expect("the last state is always reported");
    let load: f64 = end.soles.iter().flat_map(|s| &s.forces).map(|f| f.z).sum();
    // The sway has decayed (at about 12 1/s): after 10 s the rest is integration noise.
    assert!((load / weight - 1.0).abs() < 1e-6, "{load} {weight}");
    // Moments balance: the centre of pressure is under the centre of mass.
    let pressure = end.centre_of_pressure.expect("it stands");
    assert!((pressure - end.com).xy().norm() < 1e-6, "{pressure} {}", end.com);
}

#[test]
fn one_step_agrees_with_exact_without_state_changes() {
    let (a, b) = (run(&standing("exact", 1.0, ADAPTIVE)), run(&standing("one-step", 1.0, ADAPTIVE)));
    for i in 0..3 {
        // Same equations, other steps: the integrator's tolerance over a swaying second.
        assert!((a.final_base_position[i] - b.final_base_position[i]).abs() < 1e-8);
        assert!((a.final_base_rpy[i] - b.final_base_rpy[i]).abs() < 1e-8);
    }
    assert!(a.final_base_position[2] < 0.9999 * simulation(&standing("exact", 1.0, ADAPTIVE)).plant().state.position.z);
}

#[test]
fn semi_implicit_is_of_first_order() {
    let (speed, mu) = (2.0, 0.5);
    let truth = speed * speed / (2.0 * mu * G);
    for method in ["exact", "one-step"] {
        let error = |step: f64| {
            let m = run(&format!(
                "duration = 0.6
                robot = {{ model = \"robots/block/block.toml\", base = {{ linear_velocity = [{speed}, 0.0, 0.0] }} }}
                floor = {{ friction = {mu} }}
                contact = {{ method = \"{method}\" }}
                integrator = {{ method = \"semi-implicit\", step = {step} }}\n"
            ));
            m.final_base_position[0] - truth
        };
        let errors = [4e-3, 2e-3, 1e-3, 5e-4].map(error);
        for (e, step) in errors.iter().zip([4e-3, 2e-3, 1e-3, 5e-4]) {
            // Each step moves with the velocity at its end, mu g dt lower than at its start: v dt /
            // 2 short in all, and up to mu g dt^2 / 8 from the position of the stop in its step.
            // The one-step method sticks only after the velocity has reversed, having slid back by
            // at most mu g dt^2.
            let expected = -speed * step / 2.0;
            let stop = mu * G * step * step * if method == "exact" { 0.125 } else { 1.0 };
            assert!((e - expected).abs() < stop + 1e-9, "{method} {step}: {e} {expected}");
        }
    }
}

#[test]
fn the_energy_loss_of_fixed_steps_is_of_the_order_of_the_step() {
    for method in ["exact", "one-step"] {
        let error = |step: f64| {
            let m = run(&format!(
                r#"
                duration = 2.0
                robot = {{ model = "robots/hoap2/hoap2.toml" }}
                contact = {{ method = "{method}" }}
                integrator = {{ method = "semi-implicit", step = {step} }}
                [[force]]
                type = "push"
                link = "torso"
                point = [0, 0, 0.1]
                force = [15, 0, 0]
                start = 0.5
                duration = 0.1
                profile = "half-sine"
                "#
            ));
            // Rocking feet land within distance_tolerance, 1 mm, which raises the base by no more.
            assert!((m.final_base_position[2] - 0.2834).abs() < 1e-3, "{method} {step}: {m:?}");
            m.energy_error_j.abs()
        };
        let (coarse, fine) = (error(1e-3), error(2e-4));
        // First order in the step: a fifth of the error, and no energy gain when vertices are
        // clamped above the floor. A quarter leaves room for landings at different instants of the
        // steps.
        assert!(coarse < 1e-3 && fine < coarse / 4.0, "{method}: {coarse:e} {fine:e}");
    }
}
