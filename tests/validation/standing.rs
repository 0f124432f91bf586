//! Robots and boxes at rest: slopes, loads inside the friction cone, feet.

use super::case::Case;
use crate::analytic::body::G;

/// No motion, and the floor carries the weight: `m g cos tilt` along its normal.
/// `final_base_shift_m` is zero.
pub fn still(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let [roll, pitch, _] = case.run.scenario.floor.rpy;
    // The third component of the floor's normal.
    let upright = roll.cos() * pitch.cos();
    assert!((1.0 / (upright * upright) - 1.0).sqrt() < case.mu_s(), "inside the cone");
    (metric == "final_normal_force_N").then(|| case.mass() * G * upright)
}
