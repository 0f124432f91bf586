//! Integrators converge with their orders: on smooth motion, and through a landing, because events
//! are located.

use super::body::{Body, G};
use crate::support::runs::{finish, run, simulation};
use stiction::sim::{Metrics, NullObserver};

/// Integrator tables for steps of `h`, each with its order; adaptive ones have tolerances that are
/// never active. Their first steps are shorter, as they begin with 1 ms.
fn integrators(h: f64) -> [(String, f64); 5] {
    let loose = "relative_tolerance = 1e6, absolute_tolerance = 1e6";
    [
        (format!("method = \"dopri5\", {loose}, max_step = {h}"), 5.0),
        (format!("method = \"bs23\", {loose}, max_step = {h}"), 3.0),
        (format!("method = \"rk4\", step = {h}"), 4.0),
        (format!("method = \"rosenbrock\", {loose}, max_step = {h}"), 3.0),
        (format!("method = \"semi-implicit\", step = {h}"), 1.0),
    ]
}

const REFERENCE: &str = "relative_tolerance = 1e-13, absolute_tolerance = 1e-14, max_step = 1e-3";

const PENDULUM: &str = "duration = 1.0
    [robot]
    model = \"robots/pendulum/pendulum.urdf\"
    soles = []
    joint_default = { mode = \"passive\" }
    posture = { shoulder = 1.2, elbow = 0.6 }
    velocity = { shoulder = 1.0, elbow = -0.5 }\n";

/// The scenario in which a body lands on a corner, which rests from then on.
fn landing(body: &Body) -> String {
    let base =
        "position = [0, 0, 0.2], rpy = [0.5, 0.4, 0], linear_velocity = [0.5, 0.2, -1], angular_velocity = [2, -3, 1]";
    format!(
        "duration = 0.1\nfloor = {{ friction = 3.0 }}\ncontact = {{ velocity_tolerance = 1e-6 }}\n{}",
        body.robot(base)
    )
}

/// Positions and velocities at the end.
fn end(scenario: &str, integrator: &str) -> (Vec<f64>, Metrics) {
    let mut sim = simulation(&format!("integrator = {{ {integrator} }}\nlog = {{ rate = 0 }}\n{scenario}"));
    let metrics = finish(&mut sim, &mut NullObserver);
    let state = &sim.plant().state;
    let turned = state.rotation.scaled_axis();
    let parts = [state.position.as_slice(), turned.as_slice(), &state.joints, &state.v];
    (parts.concat(), metrics)
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Observed orders of the integrators between steps of `h` and `h / 2`, minus their nominal orders.
fn excess(scenario: &str, steps: [f64; 5]) -> [f64; 5] {
    let truth = end(scenario, REFERENCE).0;
    std::array::from_fn(|i| {
        let error = |h: f64| {
            let (integrator, order) = integrators(h)[i].clone();
            (apart(&end(scenario, &integrator).0, &truth), order)
        };
        let ((coarse, order), (fine, _)) = (error(steps[i]), error(0.5 * steps[i]));
        (coarse / fine).log2() - order
    })
}

#[test]
fn a_double_pendulum_converges_with_the_order_of_its_integrator() {
    let found = excess(PENDULUM, [0.01, 0.01, 4e-3, 5e-3, 1e-3]);
    // The next order, at some 0.1 to 0.2 rad a step; adaptive runs begin with shorter steps, at
    // most two of fifty.
    assert!(found.iter().all(|x| x.abs() < 0.3), "{found:?}");
}

#[test]
fn a_humanoid_in_flight_converges_with_the_order_of_its_integrator() {
    let found = excess(
        "duration = 0.1
        [robot]
        model = \"robots/hoap2/hoap2.toml\"
        base = { position = [0, 0, 2], linear_velocity = [0.7, -0.3, 2.0], angular_velocity = [0.3, 0.6, 0.2] }
        velocity = { left_knee = 0.2, right_shoulder_pitch = -0.3 }\n",
        [2e-3, 1e-3, 1e-3, 5e-4, 2e-4],
    );
    // No drive is at its limit, where its effort would have a kink. Servos make rates of some 300
    // 1/s, so the next order contributes a tenth to a third. For `dopri5` it contributes two
    // thirds, and the error then falls faster. Its steps cannot be shorter, or rounding would
    // dominate.
    assert!(found[1..].iter().all(|x| x.abs() < 0.3) && (-0.3..1.0).contains(&found[0]), "{found:?}");
}

#[test]
fn a_landing_on_a_corner_converges_with_the_order_of_its_integrator() {
    let body = Body::new([0.1, 0.08, 0.05], 1.3);
    let scenario = landing(&body);
    let (_, m) = end(&scenario, REFERENCE);
    assert_eq!((m.impacts, m.state_changes, m.inconsistent), (1, 1, 0), "{m:?}");
    let found = excess(&scenario, [0.01, 0.01, 0.01, 5e-3, 2e-4]);
    // Flight and swing about the corner rotate by 0.05 rad a step. The velocity-level step meets
    // the floor anywhere within a step, so its error fluctuates, and the test does not check it.
    assert!(found[..4].iter().all(|x| x.abs() < 0.5), "{found:?}");
}

/// Backward differentiation formulas choose their order, so their errors are compared with the tolerance.
#[test]
fn errors_of_formulas_fall_with_the_tolerance() {
    let body = Body::new([0.1, 0.08, 0.05], 1.3);
    for scenario in [PENDULUM, &landing(&body)] {
        let truth = end(scenario, REFERENCE).0;
        let of = |tolerance: f64| {
            let keys = format!("method = \"bdf\", relative_tolerance = {tolerance}, absolute_tolerance = {tolerance}");
            apart(&end(scenario, &keys).0, &truth)
        };
        for tolerance in [1e-4, 1e-6, 1e-8] {
            // Speeds of some 4 rad/s; errors of steps add up.
            let error = of(tolerance);
            assert!(error < 10.0 * tolerance, "{tolerance} {error}");
        }
    }
}

#[test]
fn a_slide_has_the_exact_length_with_every_integrator_that_locates_events() {
    // Constant deceleration is exact for all of them, so the error is that of the location of the
    // stop.
    for (integrator, _) in &integrators(7e-3)[..4] {
        let m = run(&format!(
            "duration = 1.0\nrobot = {{ model = \"robots/block/block.toml\", base = {{ linear_velocity = [2, 0, 0] }} }}\n\
             floor = {{ friction = 0.5 }}\nintegrator = {{ {integrator} }}\n"
        ));
        let (time, way) = (2.0 / (0.5 * G), 2.0 / (0.5 * G));
        // Rounding over 150 steps.
        assert!((m.first_stick_s.expect("it stops") - time).abs() < 1e-12, "{integrator} {m:?}");
        assert!((m.final_base_position[0] - way).abs() < 1e-12, "{integrator} {m:?}");
        assert_eq!((m.events, m.state_changes, m.rejected_steps), (1, 1, 0), "{integrator}");
    }
}

#[test]
fn an_unstable_step_size_is_detected() {
    // The spring of the end stop oscillates at sqrt(k / I), far beyond 2.8 / h. The run must end
    // with an error instead of hanging.
    let mut sim = simulation(
        "duration = 10.0\nrobot = { model = \"robots/hoap2/hoap2.toml\" }\ncontact = { method = \"penalty\", \
         penalty = { stiffness = 1e7 } }\nintegrator = { method = \"rk4\", step = 0.02 }\nlog = { rate = 0 }\n",
    );
    let (outcome, message) = sim.run(&mut NullObserver, &std::sync::atomic::AtomicBool::new(false));
    assert_eq!(outcome, stiction::sim::Outcome::Diverged, "{message}");
}
