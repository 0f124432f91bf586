//! The planar motion of a box that slides and rotates on four corners: equations independent of the
//! simulator.
//!
//! ```text
//! m v' = -mu sum N_i u_i      I_z w' = -mu sum N_i (r_i x u_i)      u_i = (v + w z x r_i) / |...|
//! ```
//!
//! The corners' loads follow the pressure rule, linear while all are positive: `N_i = A + B x_i + C
//! y_i` with `sum N_i = m g`. Friction acts a height c below the centre and the box does not tilt,
//! so `sum N_i r_i = c mu sum N_i u_i`. The equations do not require a flat body, only all N_i > 0.

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

/// As [`derivative`], with separate friction at each corner.
pub fn derivative_on(body: &Body, mu: [f64; 4], s: &[f64; 6]) -> [f64; 6] {
    on_feet(&body.corners(), &mu, [body.half[2], body.mass, body.inertia()[2]], s)
}

/// As [`derivative`] for any points of contact below a body of centre height (m), mass (kg) and inertia about z (kg m^2).
pub fn on_feet(feet: &[[f64; 2]], mu: &[f64], [height, mass, inertia]: [f64; 3], s: &[f64; 6]) -> [f64; 6] {
    let (sin, cos) = s[2].sin_cos();
    let feet: Vec<_> = feet.iter().map(|[x, y]| Vector2::new(x * cos - y * sin, x * sin + y * cos)).collect();
    let slip: Vec<_> = feet.iter().map(|r| Vector2::new(s[3] - s[5] * r.y, s[4] + s[5] * r.x).normalize()).collect();
    let mut balance = Matrix3::zeros();
    for ((r, u), mu) in feet.iter().zip(&slip).zip(mu) {
        let lean = Vector3::new(1.0, r.x - height * mu * u.x, r.y - height * mu * u.y);
        balance += lean * Vector3::new(1.0, r.x, r.y).transpose();
    }
    let pressure = balance.lu().solve(&Vector3::new(mass * G, 0.0, 0.0)).expect("three feet or more, not in a row");
    let (mut force, mut moment) = (Vector2::zeros(), 0.0);
    for ((r, u), mu) in feet.iter().zip(&slip).zip(mu) {
        let n = pressure.dot(&Vector3::new(1.0, r.x, r.y));
        assert!(n > 0.0, "the pressure rule is linear only while every point carries");
        force -= u * (mu * n);
        moment -= r.perp(u) * (mu * n);
    }
    [s[3], s[4], s[5], force.x / mass, force.y / mass, moment / inertia]
}
