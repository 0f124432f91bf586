//! The penalty method against its own equations, and against `exact` as its springs stiffen and its
//! slip velocity decreases.

use super::body::{Body, G};
use crate::support::runs::{finish, run, simulation, watch};
use std::f64::consts::PI;
use stiction::sim::{Metrics, NullObserver};

const FINE: &str = "relative_tolerance = 1e-10, absolute_tolerance = 1e-12";

/// The size of the repository's block, 1.3 kg, on four vertices.
fn block() -> Body {
    Body::new([0.1, 0.08, 0.05], 1.3)
}

/// A scenario of the body under the penalty method. `contact` and `integrator` are the insides of their tables.
fn scenario(body: &Body, base: &str, duration: f64, penalty: &str, integrator: &str) -> String {
    format!(
        "duration = {duration}\n{}contact = {{ method = \"penalty\", penalty = {{ {penalty} }} }}\n\
         integrator = {{ {integrator} }}\n",
        body.robot(base)
    )
}

/// The same body with its sole at the height of its centre, so that friction does not tilt it.
fn level(text: &str, body: &Body) -> String {
    text.replace(&format!("-{}]", body.half[2]), "0.0]")
}

fn springs(k: f64, c: f64, s: f64) -> String {
    format!("stiffness = {k}, damping = {c}, slip_velocity = {s}")
}

#[test]
fn a_body_at_rest_deflects_its_springs_by_its_weight() {
    let body = block();
    for integrator in [FINE, "method = \"rosenbrock\"", "method = \"bdf\"", "method = \"semi-implicit\", step = 1e-3"] {
        for k in [1e3, 1e4, 1e5, 1e6] {
            // Nearly critical damping: e^-(omega t) is below 1e-12 after a second at 1e3 N/m.
            let c = (k * body.mass / 4.0).sqrt() * 2.0;
            let m = run(&scenario(&body, "", 1.0, &springs(k, c, 1e-3), integrator));
            let depth = body.mass * G / (4.0 * k);
            let sunk = body.half[2] - m.final_base_position[2];
            // The rest of the transient, and rounding of a height of 0.05 m: 1e-17 / 3e-6 m.
            assert!((sunk / depth - 1.0).abs() < 1e-9, "{integrator} {k}: {sunk} {depth}");
            assert!(m.max_penetration_m >= sunk && m.max_penetration_m < 1.1 * depth, "{m:?}");
            assert_eq!((m.max_tension_n, m.max_cone_excess, m.impacts), (0.0, 0.0, 0));
        }
    }
}

#[test]
fn a_body_settles_as_a_damped_oscillator() {
    // z'' + 2 b z' + w^2 z = -g from the floor at rest, with b = n c / 2 m and w^2 = n k / m.
    let (body, k, c) = (block(), 2e4, 20.0);
    let (w2, b) = (4.0 * k / body.mass, 2.0 * c / body.mass);
    let damped = (w2 - b * b).sqrt();
    for t in [0.003, 0.01, 0.02, 0.05, 0.11] {
        let m = run(&scenario(&body, "", t, &springs(k, c, 1e-3), FINE));
        let decay = (-b * t).exp();
        let z = -G / w2 * (1.0 - decay * ((damped * t).cos() + b / damped * (damped * t).sin()));
        let v = -G / damped * decay * (damped * t).sin();
        // Tolerances of 1e-12 m and m/s over some hundred steps.
        assert!((m.final_base_position[2] - body.half[2] - z).abs() < 1e-10, "{t}: {m:?} {z}");
        assert!((m.final_base_velocity[2] - v).abs() < 1e-9, "{t}: {m:?} {v}");
    }
}

#[test]
fn without_damping_a_body_bounces_back_to_its_height() {
    // In the air for 2 sqrt(2 h / g), in contact for 2 (pi - atan(w v / g)) / w.
    let (body, k, h) = (block(), 1e4, 0.01);
    let w = (4.0 * k / body.mass).sqrt();
    let v = (2.0 * G * h).sqrt();
    let period = 2.0 * v / G + 2.0 / w * (PI - (w * v / G).atan());
    let base = format!("position = [0, 0, {}]", body.half[2] + h);
    let m = run(&scenario(&body, &base, 3.0 * period, &springs(k, 0.0, 1e-3), FINE));
    // Touch-down and lift-off are located; relative tolerance 1e-10 over three bounces.
    assert!((m.final_base_position[2] - body.half[2] - h).abs() < 1e-10, "{m:?}");
    assert!(m.final_base_velocity[2].abs() < 1e-8, "{m:?}");
    assert!(m.max_energy_error_j < 1e-9 && m.impact_loss_j.abs() < 1e-9, "{m:?}");
    // It leaves the floor and touches it at six instants, and the released springs store no energy.
    assert_eq!((m.state_changes, m.max_tension_n), (6, 0.0));
    let deepest = G / (w * w) + (v * v / (w * w) + (G / (w * w)).powi(2)).sqrt();
    // Sampled at the ends of steps, which are up to a tenth of a radian from the deepest point.
    assert!(m.max_penetration_m <= deepest * (1.0 + 1e-9) && m.max_penetration_m > 0.99 * deepest, "{m:?}");
}

#[test]
fn a_sticking_body_creeps_in_proportion_to_the_slip_velocity() {
    // tan(angle) = mu v / sqrt(v^2 + s^2): v = s r / sqrt(1 - r^2) with r the used fraction of the
    // cone.
    let (body, mu) = (block(), 0.6_f64);
    for integrator in [FINE, "method = \"rosenbrock\"", "method = \"bdf\"", "method = \"semi-implicit\", step = 1e-3"] {
        for s in [1e-2, 1e-3, 1e-4] {
            for r in [0.3, 0.9] {
                let angle = (r * mu).atan();
                let creep = s * r / f64::sqrt(1.0 - r * r);
                let text = format!(
                    "floor = {{ friction = {{ static = 0.9, kinetic = {mu} }}, rpy = [0, {angle}, 0] }}\n{}",
                    scenario(&body, &format!("rpy = [0, {angle}, 0]"), 0.5, &springs(1e4, 200.0, s), integrator)
                );
                let m = run(&text);
                let [x, _, z] = m.final_base_velocity;
                let speed = x.hypot(z);
                // The rest of the transient after 0.5 s, and tolerances of 1e-12 m/s.
                assert!((speed / creep - 1.0).abs() < 1e-7, "{integrator} {s} {r}: {speed} {creep}");
                // The state is sticking below the slip velocity, and the residuals show the creep.
                let sticks = creep < s;
                let shown = m.max_creep_speed_m_per_s;
                assert_eq!(shown >= creep * (1.0 - 1e-7), sticks, "{shown} {creep}");
                assert_eq!(m.max_static_creep_m > 0.3 * creep, sticks, "{}", m.max_static_creep_m);
                assert_eq!(m.max_cone_excess, 0.0);
            }
        }
    }
}

/// Distance of a point that slides from v and approaches rest asymptotically: x'' = -mu g x' /
/// sqrt(x'^2 + s^2).
fn way(v: f64, mu: f64, s: f64) -> f64 {
    (v * v.hypot(s) + s * s * (v / s).asinh()) / (2.0 * mu * G)
}

#[test]
fn a_slide_converges_to_the_exact_one_with_stiffness_and_slip_velocity() {
    let (body, mu, v) = (block(), 0.5, 1.0);
    let exact = v * v / (2.0 * mu * G);
    let slide = |k: f64, s: f64, integrator: &str| {
        let c = (k * body.mass / 4.0).sqrt();
        let text = scenario(&body, &format!("linear_velocity = [{v}, 0, 0]"), 1.0, &springs(k, c, s), integrator);
        run(&level(&format!("floor = {{ friction = {mu} }}\n{text}"), &body))
    };
    let mut errors = Vec::new();
    for (k, s) in [(1e4, 0.04), (1e5, 0.02), (1e6, 0.01)] {
        let m = slide(k, s, FINE);
        // While the springs take up the weight, friction lacks as much as the floor force: mu times
        // the depth.
        let depth = body.mass * G / (4.0 * k);
        let truth = way(v, mu, s) + mu * depth;
        let [x, y, _] = m.final_base_position;
        // Meanwhile, at nearly v, it lacks s^2 / (2 v^2) of that; and tolerances of 1e-12 over some
        // 10000 steps.
        let missed = mu * depth * s * s / (2.0 * v * v);
        assert!((x - truth).abs() < 1.2 * missed + 1e-9 && y.abs() < 1e-12, "{k} {s}: {x} {truth} {missed}");
        errors.push(x - exact);
    }
    // Both parts decrease: that of the springs as 1 / k, that of friction as s^2 (log(2 v / s) + 1
    // / 2).
    let predicted: Vec<f64> = [(1e4, 0.04), (1e5, 0.02), (1e6, 0.01)]
        .map(|(k, s): (f64, f64)| s * s * ((2.0 * v / s).ln() + 0.5) / (2.0 * mu * G) + mu * body.mass * G / (4.0 * k))
        .to_vec();
    for (error, predicted) in errors.iter().zip(&predicted) {
        // The expansion of `way` in s leaves s^4.
        assert!((error / predicted - 1.0).abs() < 1e-2, "{errors:?} {predicted:?}");
    }
    // In fixed steps of h the distance is short by v h / 2 to first order.
    let short = |h: f64| {
        way(v, mu, 0.01) - slide(1e6, 0.01, &format!("method = \"semi-implicit\", step = {h}")).final_base_position[0]
    };
    let (a, b) = (short(1e-3), short(5e-4));
    assert!((a / (0.5e-3 * v) - 1.0).abs() < 0.02 && (a / b - 2.0).abs() < 0.04, "{a} {b}");
}

#[test]
fn a_slide_with_spin_converges_to_the_exact_one_with_the_slip_velocity() {
    let body = block();
    let base = "linear_velocity = [0.8, 0.3, 0], angular_velocity = [0, 0, 5]";
    let end = |contact: &str| {
        let text = format!(
            "duration = 0.6\nfloor = {{ friction = 0.4 }}\n{}contact = {{ {contact} }}\nintegrator = {{ {FINE} }}\n",
            body.robot(base)
        );
        let m = run(&level(&text, &body));
        [m.final_base_position[0], m.final_base_position[1], m.final_base_rpy[2]]
    };
    let exact = end("velocity_tolerance = 1e-8");
    let error = |k: f64, s: f64| {
        let penalty = end(&format!("method = \"penalty\", penalty = {{ {} }}", springs(k, (k / 4.0).sqrt(), s)));
        penalty.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let errors = [(1e4, 0.04), (1.6e5, 0.01), (2.56e6, 0.0025)].map(|(k, s)| error(k, s));
    // Second order in s except for its logarithm, and 1 / k as well: a factor of 16 each time, less
    // some for the logarithm.
    assert!(errors.windows(2).all(|e| (9.0..18.0).contains(&(e[0] / e[1]))), "{errors:?}");
}

#[test]
fn states_report_loaded_vertices_and_slip() {
    let (body, mu, v, s) = (block(), 0.5, 1.0, 1e-3);
    let text = scenario(&body, &format!("linear_velocity = [{v}, 0, 0]"), 0.5, &springs(1e5, 300.0, s), FINE);
    let (m, recording) = watch(&level(&format!("floor = {{ friction = {mu} }}\n{text}"), &body));
    let reach = |v: f64| (v.hypot(s) - s * (s / v).asinh()) / (mu * G);
    let truth = reach(v) - reach(s);
    let stick = m.first_stick_s.expect("it stops");
    // Read at the end of a step; steps are some 1e-4 s where friction is stiff.
    assert!(stick >= truth - 1e-9 && stick < truth + 1e-3, "{stick} {truth}");
    let kinds: Vec<_> = recording.events.iter().map(|e| e.kind).collect();
    assert_eq!(kinds, ["touchdown", "stick"]);
    let states: Vec<_> = recording.snapshots.iter().map(|s| s.soles[0].state.as_str()).collect();
    assert_eq!((states[1], states[states.len() - 1]), ("face-dynamic", "face-static"));
    assert_eq!((m.inconsistent, m.selections, m.jams), (0, 0, 0));
    for snapshot in &recording.snapshots[1..] {
        let forces = &snapshot.soles[0].forces;
        let sum: nalgebra::Vector3<f64> = forces.iter().sum();
        assert!(sum.z > 0.0 && forces.iter().all(|f| f.z > 0.0 && f.xy().norm() <= mu * f.z * (1.0 + 1e-12)));
        assert!(snapshot.residual.resultant_gap < 1e-12 * body.mass * G);
    }
}

#[test]
fn energy_balances_with_the_energy_of_the_springs() {
    let body = block();
    let base = "position = [0, 0, 0.12], rpy = [0.2, 0.3, 0], linear_velocity = [0.5, 0.2, 0]";
    let fall = |integrator: &str| run(&scenario(&body, base, 1.0, "", integrator));
    let m = fall(FINE);
    // The energies are integrated along with the state, but do not control the step size. Where a
    // damper releases with a kink, at powers of 1e2 W and steps of 1e-5 s, this gives an error.
    assert!(m.max_energy_error_j < 5e-7, "{m:?}");
    assert!(m.impact_loss_j > 0.5 && m.friction_loss_j > 0.1 && m.max_tension_n == 0.0, "{m:?}");
    // Fixed steps: the work of the floor is exact, that of gravity of first order.
    let errors = [1e-4, 5e-5].map(|h| fall(&format!("method = \"semi-implicit\", step = {h}")).max_energy_error_j);
    assert!((1.7..2.3).contains(&(errors[0] / errors[1])) && errors[0] < 2e-3, "{errors:?}");
}

#[test]
fn a_patch_has_its_own_friction() {
    let (body, v, s) = (block(), 1.0, 1e-2);
    let text = scenario(&body, &format!("linear_velocity = [{v}, 0, 0]"), 1.0, &springs(1e6, 500.0, s), FINE);
    let floor =
        "floor = { friction = 0.9, patches = [{ polygon = [[-1, -1], [2, -1], [2, 1], [-1, 1]], friction = 0.4 }] }";
    let m = run(&level(&format!("{floor}\n{text}"), &body));
    let truth = way(v, 0.4, s) + 0.4 * body.mass * G / 4e6;
    // As for the slide above.
    assert!((m.final_base_position[0] - truth).abs() < 1e-8, "{m:?} {truth}");
}

#[test]
fn the_springs_carry_the_weight_of_a_standing_robot() {
    for integrator in
        ["max_step = 1e-3", "method = \"rosenbrock\"", "method = \"bdf\"", "method = \"semi-implicit\", step = 1e-3"]
    {
        let mut sim = simulation(&format!(
            "duration = 1.0\nrobot = {{ model = \"robots/hoap2/hoap2.toml\" }}\ncontact = {{ method = \"penalty\" }}\n\
             integrator = {{ {integrator} }}\n"
        ));
        let weight = sim.plant().model.mass() * G;
        let m: Metrics = finish(&mut sim, &mut NullObserver);
        // It still sways on its servos, and creeps.
        assert!((m.final_normal_force_n.expect("at its end") / weight - 1.0).abs() < 1e-3, "{m:?}");
        assert!(m.max_penetration_m > 0.5 * weight / 8e5 && m.max_penetration_m < 5.0 * weight / 8e5, "{m:?}");
        assert!(m.max_static_creep_m > 0.0 && m.max_cone_excess == 0.0, "{m:?}");
    }
}

#[test]
fn stages_below_the_floor_take_no_energy_before_a_touch_down() {
    let m = run("duration = 1.0\nlog.rate = 0\ncontact.method = \"penalty\"\nintegrator.method = \"rosenbrock\"\n\
         [robot]\nmodel = \"robots/block/block.toml\"\n\
         base = { position = [0, 0, 0.25], rpy = [0, \"30 deg\", \"45 deg\"] }\n");
    // Of 2 J, with steps at a tolerance of 1e-6. The power of springs at vertices outside the floor made it 0.06 J.
    assert!(m.max_energy_error_j < 1e-4 && m.impact_loss_j > 1.0, "{m:?}");
}
