//! Boxes that are pushed over.

use super::case::Case;
use crate::analytic::body::G;
use crate::support::runs::rk4;

/// Height of the push above the floor and its full size; it acts along the box's x axis.
fn pushed(case: &Case) -> (f64, f64) {
    let push = case.push();
    let [x, y, z] = push.force;
    assert!(x > 0.0 && y == 0.0 && z == 0.0 && push.duration == 1.0 && push.start == 0.0);
    (push.point[2] + case.half()[2], x)
}

/// Slides at `mu m g` if `mu < b / h`, else tips at `m g b / h`.
pub fn onset(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let (height, full) = pushed(case);
    let limit = case.half()[0] / height;
    match metric {
        "first_slip_s" => (case.mu_s() < limit).then(|| case.mu_s() * case.weight() / full),
        "first_tip_s" => (case.mu_s() > limit).then(|| limit * case.weight() / full),
        "state_changes" => Some(1.0),
        _ => None,
    }
}

/// `I phi'' = F (h cos phi + a sin phi) - m g (a cos phi - c sin phi)` from the instant of tipping.
pub fn pendulum(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let (height, full) = pushed(case);
    let [a, _, c] = case.half();
    assert!(case.mu_s() > a / height);
    let start = case.weight() * a / (height * full);
    let inertia = case.inertia()[1] + case.mass() * (a * a + c * c);
    let [tilt, rate] = rk4([0.0, 0.0], case.duration() - start, 4000, |t, [phi, rate]: &[f64; 2]| {
        let (sin, cos) = phi.sin_cos();
        let force = full * (start + t);
        [*rate, (force * (height * cos + a * sin) - case.mass() * G * (a * cos - c * sin)) / inertia]
    });
    match metric {
        "final_base_pitch" => Some(tilt),
        "final_base_wy_rad_s" => Some(rate),
        "first_tip_s" => Some(start),
        "state_changes" => Some(1.0),
        _ => None,
    }
}
