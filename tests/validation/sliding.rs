//! Boxes that slide and rotate on the floor.

use super::case::Case;
use crate::analytic::body::{Body, G};
use crate::analytic::planar;
use crate::support::runs::rk4;

fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// `x = v0^2 / (2 mu g)`, `t = v0 / (mu g)`.
pub fn stop(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let (speed, mu) = (norm(case.base().linear_velocity), case.mu_k());
    match metric {
        "final_base_shift_m" => Some(speed * speed / (2.0 * mu * G)),
        "first_stick_s" => Some(speed / (mu * G)),
        "state_changes" => Some(1.0),
        _ => None,
    }
}

/// `g (sin - mu cos) t^2 / 2` straight down a floor turned by `[0, tilt, heading]`.
pub fn slope(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let [roll, tilt, heading] = case.run.scenario.floor.rpy;
    assert_eq!((roll, case.base().rpy), (0.0, [0.0, tilt, heading]));
    assert!(tilt.tan() > case.mu_s());
    let way = G * (tilt.sin() - case.mu_k() * tilt.cos()) * case.duration().powi(2) / 2.0;
    match metric {
        "final_base_shift_m" => Some(way),
        "final_base_x" => Some(way * tilt.cos() * heading.cos()),
        "final_base_y" => Some(way * tilt.cos() * heading.sin()),
        _ => None,
    }
}

/// A push that grows linearly slips the box when it reaches `mu_s m g`.
pub fn push(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let push = case.push();
    assert_eq!(push.point[2], -case.half()[2], "at the floor, so that it does not tip");
    (metric == "first_slip_s").then(|| push.duration * case.mu_s() * case.weight() / norm(push.force))
}

/// A yaw moment that grows linearly slips the box when it reaches `mu_s m g r`.
pub fn turn(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let push = case.push();
    (metric == "first_slip_s").then(|| push.duration * case.mu_s() * case.weight() * case.radius() / norm(push.moment))
}

/// `theta'' = -mu m g r / I_z`.
pub fn spin(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let rate = case.base().angular_velocity[2];
    let decay = case.mu_k() * case.weight() * case.radius() / case.inertia()[2];
    match metric {
        "first_stick_s" => Some(rate.abs() / decay),
        "final_base_yaw" => Some(rate * rate.abs() / (2.0 * decay)),
        _ => None,
    }
}

/// The planar equations of a box on four corners, by fixed steps.
pub fn slide_and_spin(case: &Case, index: usize, metric: &str) -> Option<f64> {
    let body = Body::new(case.half(), case.mass());
    let ([vx, vy, _], [.., w]) = (case.base().linear_velocity, case.base().angular_velocity);
    let derivative = |_, s: &[f64; 6]| planar::derivative(&body, case.mu_k(), s);
    let names =
        ["final_base_x", "final_base_y", "final_base_yaw", "final_base_vx", "final_base_vy", "final_base_wz_rad_s"];
    let at = names.iter().position(|n| *n == metric)?;
    assert_eq!(at, index);
    Some(rk4([0.0, 0.0, 0.0, vx, vy, w], case.duration(), 2000, derivative)[at])
}
