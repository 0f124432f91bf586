//! Equations with which several methods are tested.

use super::System;

/// y0' = y1 + cos t, y1' = -y0 + c y1^2: not linear and not autonomous.
pub struct Smooth;
impl System for Smooth {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = y[1] + t.cos();
        dy[1] = -y[0] + 0.3 * y[1] * y[1];
    }
}

/// Prothero and Robinson: y' = l (y - sin t) + cos t, solution sin t.
pub struct Prothero(pub f64);
impl System for Prothero {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
        dy[0] = self.0 * (y[0] - t.sin()) + t.cos();
    }
}
