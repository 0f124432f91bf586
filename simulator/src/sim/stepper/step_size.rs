//! Step-size control of explicit integrators.

use crate::integrate::StepControl;

/// Step size of an explicit integrator.
#[derive(Clone)]
pub enum StepSize {
    /// Chosen by error control.
    Controlled {
        /// Chooses the next size.
        control: StepControl,
        /// Relative tolerance.
        relative: f64,
        /// Absolute tolerance.
        absolute: f64,
        /// Longest step, s.
        max_step: f64,
        /// The next step, s.
        h: f64,
    },
    /// Constant, s, except where a step is shortened to end at an instant.
    Fixed(f64),
}

impl StepSize {
    /// Size of the next step with `remaining` seconds before an instant at which it must end.
    pub fn next(&self, remaining: f64) -> f64 {
        let h = match self {
            StepSize::Controlled { max_step, h, .. } => h.min(*max_step),
            StepSize::Fixed(step) => *step,
        };
        let h = h.min(remaining);
        // Leaves no sliver before that instant.
        if remaining - h < 0.01 * h { remaining } else { h }
    }

    /// None if the error of the attempted step of size `h` is acceptable; else the factor to
    /// shorten it by. `error` has the relative and the absolute tolerance as argument.
    pub fn shorten(&mut self, error: impl Fn((f64, f64)) -> f64, h: f64, remaining: f64) -> Option<f64> {
        let StepSize::Controlled { control, relative, absolute, h: next, .. } = self else { return None };
        let error = error((*relative, *absolute));
        let factor = control.factor(error);
        if error <= 1.0 {
            if h < remaining || factor < 1.0 {
                *next = h * factor;
            }
            return None;
        }
        Some(factor)
    }

    /// As [`shorten`](Self::shorten) for a step that ends at an event: the size of the next step does
    /// not change.
    pub fn shorten_located(&self, error: impl Fn((f64, f64)) -> f64) -> Option<f64> {
        let StepSize::Controlled { control, relative, absolute, .. } = self else { return None };
        let error = error((*relative, *absolute));
        (!(error <= 1.0)).then(|| control.clone().factor(error))
    }

    /// Resets the size after a jump of the equations.
    pub fn restart(&mut self) {
        if let StepSize::Controlled { max_step, h, .. } = self {
            *h = max_step.min(1e-3);
        }
    }
}
