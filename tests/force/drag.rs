//! `drag`: falling through air, and carried by wind.

use super::{G, fly};
use crate::analytic::body::Body;
use nalgebra::Vector3;

fn drag(rest: &str) -> String {
    format!("[[force]]\ntype = \"drag\"\n{rest}\n")
}

fn body() -> Body {
    Body::new([0.1, 0.1, 0.05], 2.0)
}

#[test]
fn a_fall_with_linear_drag_nears_its_terminal_velocity() {
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
    // Without a link every link is meant: here the one there is.
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
fn wind_carries_along_while_it_blows() {
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
fn drag_at_a_point_off_the_centre_turns() {
    let (body, c, r, speed) = (body(), 0.5, 0.3, 2.0);
    let text =
        format!("gravity = [0, 0, 0]\n{}", drag(&format!("link = \"block\"\npoint = [0, 0, {r}]\nlinear = {c}")));
    // Translation along x with the point above the centre: the torque is about y.
    let end = fly(&body, [0.0; 3], [speed, 0.0, 0.0], 1e-4, &text);
    let rate = end.metrics.final_base_angular_velocity[1] / 1e-4;
    // The torque of the first instant; it changes by about c r^2 t / I, 1e-3 of itself.
    assert!((rate / (-c * speed * r / body.inertia()[1]) - 1.0).abs() < 1e-3, "{rate}");
}
