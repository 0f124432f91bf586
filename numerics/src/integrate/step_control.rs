//! Step-size control: the PI controller of [Hairer 1996], section IV.2.

use crate::math;

/// PI controller that chooses the next step from the errors of the last two.
#[derive(Clone, Copy, Debug)]
pub struct StepControl {
    order: f64,
    last: f64,
}

impl StepControl {
    /// Controller for a pair whose error estimate is of order h^`order`.
    pub fn new(order: u32) -> Self {
        StepControl { order: f64::from(order), last: 1e-4 }
    }

    /// Factor by which to change the step after `error` (1 is the tolerance); between 0.2 and 5, at
    /// most 1 after a rejection.
    pub fn factor(&mut self, error: f64) -> f64 {
        let beta = 0.4 / self.order;
        let alpha = 1.0 / self.order - 0.75 * beta;
        if !(error <= 1.0) {
            return if error.is_finite() { (0.9 * math::powf(error, -1.0 / self.order)).clamp(0.2, 1.0) } else { 0.2 };
        }
        let error = error.max(1e-10);
        let factor = 0.9 * math::powf(error, -alpha) * math::powf(self.last, beta);
        self.last = error.max(1e-4);
        factor.clamp(0.2, 5.0)
    }
}
