//! The planar motion of a box that slides and turns on four corners: typed-in equations, apart from the simulator's.
//!
//! ```text
//! m v' = -mu sum N_i u_i      I_z w' = -mu sum N_i (r_i x u_i)      u_i = (v + w z x r_i) / |...|
//! ```
//!
//! The corners' loads follow the pressure rule, linear while all are positive: `N_i = A + B x_i + C y_i` with `sum N_i =
//! m g` and, since friction acts a height c below the centre and the box does not tilt, `sum N_i r_i = c mu sum N_i u_i`.
//! Nothing here asks for a flat body; only all N_i > 0.

use super::body::{Body, G};
use nalgebra::{Matrix3, Vector2, Vector3};

/// The corners relative to the centre, world axes.
pub fn corners(body: &Body, yaw: f64) -> [Vector2<f64>; 4] {
    let (sin, cos) = yaw.sin_cos();
    body.corners().map(|[x, y]| Vector2::new(x * cos - y * sin, x * sin + y * cos))
}

/// Derivative of `[x, y, yaw, vx, vy, w]`.
pub fn derivative(body: &Body, mu: f64, s: &[f64; 6]) -> [f64; 6] {
    derivative_on(body, [mu; 4], s)
}

/// As [`derivative`], with friction of its own at each corner.
pub fn derivative_on(body: &Body, mu: [f64; 4], s: &[f64; 6]) -> [f64; 6] {
    let c = body.half[2];
    let corners = corners(body, s[2]);
    let slip = corners.map(|r| Vector2::new(s[3] - s[5] * r.y, s[4] + s[5] * r.x).normalize());
    let mut balance = Matrix3::zeros();
    for ((r, u), mu) in corners.iter().zip(&slip).zip(mu) {
        balance += Vector3::new(1.0, r.x - c * mu * u.x, r.y - c * mu * u.y) * Vector3::new(1.0, r.x, r.y).transpose();
    }
    let pressure = balance.lu().solve(&Vector3::new(body.mass * G, 0.0, 0.0)).expect("four corners");
    let (mut force, mut moment) = (Vector2::zeros(), 0.0);
    for ((r, u), mu) in corners.iter().zip(&slip).zip(mu) {
        let n = pressure.dot(&Vector3::new(1.0, r.x, r.y));
        assert!(n > 0.0, "the pressure rule is linear only while every corner carries");
        force -= u * (mu * n);
        moment -= r.perp(u) * (mu * n);
    }
    [s[3], s[4], s[5], force.x / body.mass, force.y / body.mass, moment / body.inertia()[2]]
}
