//! `drag`: fall through air, and motion with the wind.

use super::{G, fly};
use crate::analytic::body::Body;
use crate::support::runs::{finish, simulation};
use nalgebra::Vector3;
use stiction::sim::NullObserver;

fn drag(rest: &str) -> String {
    format!("[[force]]\ntype = \"drag\"\n{rest}\n")
}

fn body() -> Body {
    Body::new([0.1, 0.1, 0.05], 2.0)
}

#[test]
fn a_fall_with_linear_drag_approaches_terminal_velocity() {
    let (body, c, t) = (body(), 3.0, 2.0);
    let end = fly(&body, [0.0, 0.0, 9.0], [0.0; 3], t, &drag(&format!("link = \"block\"\nlinear = {c}")));
    let tau = body.mass / c;
    let (terminal, fade) = (G * tau, (-t / tau).exp());
    let speed = terminal * (1.0 - fade);
    // Integration at relative tolerance 1e-9.
    assert!((end.velocity.z + speed).abs() < 1e-8, "{} {speed}", end.velocity);
    assert!((end.position.z - (9.0 - terminal * (t - tau * (1.0 - fade)))).abs() < 1e-8, "{}", end.position);
    assert!(speed > 0.9 * terminal && end.metrics.external_work_j < -10.0);
    assert!(end.metrics.max_energy_error_j < 1e-8, "{}", end.metrics.max_energy_error_j);
}

#[test]
fn a_fall_with_quadratic_drag_follows_the_hyperbolic_tangent() {
    let (body, c, t) = (body(), 0.9, 1.5);
    // Without `link` the force acts on every link; this robot has one.
    for link in ["link = \"block\"\n", ""] {
        let end = fly(&body, [0.0, 0.0, 9.0], [0.0; 3], t, &drag(&format!("{link}quadratic = {c}")));
        let terminal = (body.mass * G / c).sqrt();
        let s = G * t / terminal;
        assert!((end.velocity.z + terminal * s.tanh()).abs() < 1e-8, "{}", end.velocity);
        let way = terminal * terminal / G * s.cosh().ln();
        assert!((end.position.z - (9.0 - way)).abs() < 1e-8, "{} {way}", end.position);
    }
}

#[test]
fn wind_acts_while_it_blows() {
    let (body, c) = (body(), 3.0);
    let wind = [4.0, -2.0, 1.0];
    let text = format!(
        "gravity = [0, 0, 0]\n{}",
        drag(&format!("link = \"block\"\nlinear = {c}\nwind = {wind:?}\nstart = 0.5\nduration = 0.8"))
    );
    let end = fly(&body, [0.0; 3], [0.0; 3], 2.0, &text);
    let gain = 1.0 - (-0.8 * c / body.mass).exp();
    assert!((end.velocity - Vector3::from(wind) * gain).amax() < 1e-8, "{}", end.velocity);
}

#[test]
fn drag_off_the_centre_exerts_a_moment() {
    let (body, c, r, speed) = (body(), 0.5, 0.3, 2.0);
    let text =
        format!("gravity = [0, 0, 0]\n{}", drag(&format!("link = \"block\"\npoint = [0, 0, {r}]\nlinear = {c}")));
    // Translation along x with the point above the centre: the torque is about y.
    let end = fly(&body, [0.0; 3], [speed, 0.0, 0.0], 1e-4, &text);
    let rate = end.metrics.final_base_angular_velocity[1] / 1e-4;
    // The torque of the first instant; its relative change is about c r^2 t / I = 1e-3.
    assert!((rate / (-c * speed * r / body.inertia()[1]) - 1.0).abs() < 1e-3, "{rate}");
}

/// Velocity-level steps evaluate a damper at the end of the step: `v' = v / (1 + h c / m)`, at any
/// strength.
#[test]
fn stiff_drag_and_dampers_do_not_reverse_a_velocity_step() {
    let (body, h) = (body(), 1e-3);
    let steps = format!("integrator = {{ method = \"semi-implicit\", step = {h:?} }}\ngravity = [0, 0, 0]\n");
    for c in [10.0, 2.0 * body.mass / h, 1e3 * body.mass / h] {
        let held = format!(
            "[[force]]\ntype = \"spring\"\nlink = \"block\"\nstiffness = 0\ndamping = {c}\nanchor = {{ position = [0, 0, 0] }}\n"
        );
        for force in [drag(&format!("linear = {c}")), held] {
            let robot = body.floating("position = [0, 0, 1], linear_velocity = [1, -2, 0]");
            let mut sim = simulation(&format!("duration = 0.05\n{steps}{robot}{force}"));
            let metrics = finish(&mut sim, &mut NullObserver);
            let v = &sim.plant().state.v;
            let truth = (1.0 + h * c / body.mass).powi(-50);
            // Rounding over 50 steps, of a velocity of 2 m/s and of the intermediate instants.
            assert!((v[0] - truth).abs() < 5e-14 && (v[1] + 2.0 * truth).abs() < 5e-14, "{c}: {v:?} {truth}");
            let lost = 0.5 * body.mass * 5.0 * (1.0 - truth * truth);
            assert!((metrics.external_work_j + lost).abs() < 1e-12, "{c}: {} {lost}", metrics.external_work_j);
            assert!(metrics.max_energy_error_j < 1e-12, "{c}: {}", metrics.max_energy_error_j);
        }
    }
}

/// The double pendulum with drag on both links and a commanded joint; whole rows of the mass matrix
/// are involved.
#[test]
fn velocity_steps_of_jointed_robots_with_drag_converge() {
    let end = |integrator: &str, c: f64, lead: &str| {
        let text = format!(
            "duration = 0.5\nintegrator = {{ {integrator} }}
            [robot]\nmodel = \"robots/pendulum/pendulum.urdf\"\nsoles = []\nposture = {{ shoulder = 1.0, elbow = 0.5 }}
            joint_default = {{ mode = \"passive\" }}\n{lead}\n{}
            [[force]]\ntype = \"spring\"\nlink = \"lower\"\nstiffness = 5\ndamping = {c}\nanchor = {{ velocity = [0.2, 0, 0] }}\n",
            drag(&format!("linear = {c}\nquadratic = {c}\nwind = [0.5, 0, 0.2]"))
        );
        let mut sim = simulation(&text);
        let metrics = finish(&mut sim, &mut NullObserver);
        (sim.plant().state.joints.clone(), metrics)
    };
    let lead = "joint = { shoulder = { mode = \"kinematic\" } }\n[[task]]\ntype = \"sine\"
        joints = { shoulder = { amplitude = 0.3, frequency = 1.0 } }";
    for lead in ["", lead] {
        let exact = "relative_tolerance = 1e-9, absolute_tolerance = 1e-11";
        let (truth, _) = end(exact, 1.5, lead);
        let off = |step: f64| {
            let (q, metrics) = end(&format!("method = \"semi-implicit\", step = {step}"), 1.5, lead);
            assert!(metrics.max_energy_error_j < 0.1, "{step}: {}", metrics.max_energy_error_j);
            q.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (off(1e-3), off(2.5e-4));
        // Order 1: a quarter of the error, and no more than the step times the speeds of some
        // rad/s.
        assert!(coarse < 5e-3 && (3.0..5.0).contains(&(coarse / fine)), "{lead}: {coarse:e} {fine:e}");
        // Far beyond the stability limit of an explicit damper, the joint stays still except for
        // creep.
        let (q, _) = end("method = \"semi-implicit\", step = 1e-3", 1e6, lead);
        assert!(q.iter().all(|q| q.abs() < 3.0), "{lead}: {q:?}");
    }
}
