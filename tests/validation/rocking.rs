//! Housner's rocking block.
//!
//! ```text
//! omega+ / omega- = 1 - (3/2) sin^2 alpha        I phi'^2 / 2 = m g R (cos(alpha - tilt) - cos(alpha - phi))
//! ```

use super::case::Case;
use crate::analytic::body::G;

struct Block {
    /// Between the diagonal and the side, rad.
    alpha: f64,
    /// m g R / I, 1/s^2.
    stiffness: f64,
}

impl Block {
    /// Time to fall from rest at `tilt` until the block is flat: `phi = tilt - s^2` removes the
    /// root from the integrand, and Simpson's rule integrates.
    fn fall(&self, tilt: f64) -> f64 {
        let integrand = |s: f64| {
            let half = if s == 0.0 { 0.5 } else { (s * s / 2.0).sin() / (s * s) };
            let mean = tilt - s * s / 2.0;
            2.0 / (2.0 * self.stiffness * 2.0 * (self.alpha - mean).sin() * half).sqrt()
        };
        let (n, end) = (2000, tilt.sqrt());
        let h = end / n as f64;
        let inner = (1..n).map(|i| integrand(i as f64 * h) * if i % 2 == 1 { 4.0 } else { 2.0 });
        (integrand(0.0) + integrand(end) + inner.sum::<f64>()) * h / 3.0
    }
}

/// See the module documentation.
pub fn housner(case: &Case, _: usize, metric: &str) -> Option<f64> {
    let ([a, b, c], [roll, pitch, _]) = (case.half(), case.base().rpy);
    assert!((roll == 0.0) != (pitch == 0.0), "about one axis");
    let width = if roll == 0.0 { a } else { b };
    let radius = width.hypot(c);
    let block = Block { alpha: (width / c).atan(), stiffness: 0.75 * G / radius };
    let ratio = 1.0 - 1.5 * block.alpha.sin().powi(2);
    let mut tilt = roll.abs() + pitch.abs();
    // In units of m g R.
    let start = (block.alpha - tilt).cos() - block.alpha.cos();
    let (mut energy, mut time, mut impacts) = (start, block.fall(tilt), 1);
    loop {
        energy *= ratio * ratio;
        tilt = block.alpha - (block.alpha.cos() + energy).acos();
        let next = time + 2.0 * block.fall(tilt);
        if next > case.duration() {
            break;
        }
        (time, impacts) = (next, impacts + 1);
    }
    match metric {
        "first_impact_speed_ratio" => Some(ratio),
        "impacts" => Some(f64::from(impacts)),
        "last_impact_s" => Some(time),
        "impact_loss_J" => Some(case.weight() * radius * (start - energy)),
        _ => None,
    }
}
