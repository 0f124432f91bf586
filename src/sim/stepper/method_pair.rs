//! An explicit Runge-Kutta method and a Rosenbrock method for steps in which friction is stiff.
//!
//! Friction of a slow vertex turns with its direction at rates that grow without bound as its speed
//! goes to zero ([`crate::sim::plant::friction_stiffness`]). Explicit steps are then limited by
//! stability, not by accuracy. Where that limit is below the step that the Rosenbrock method takes,
//! the latter takes it. The rate is computed where an estimate is high, or explicit steps are so
//! short that something limits them.

use super::step_size::StepSize;
use crate::integrate::{Rosenbrock, RungeKutta, StepControl, Tableau};
use crate::sim::plant::Plant;
use crate::sim::plant::state_layout::StateLayout;

/// Product of step and eigenvalue up to which explicit steps are stable (`dopri5`: 3.3).
const STABLE: f64 = 3.0;
/// Estimated rate of friction up to which explicit steps are not limited noticeably, 1/s.
const MODERATE: f64 = 1e5;
/// Size of explicit steps up to which friction may limit them although the estimate is moderate, s.
const SHORT: f64 = 1e-5;
/// First step of the Rosenbrock method after a restart, s.
const FIRST: f64 = 1e-4;
/// Most explicit steps between two attempts to resume the Rosenbrock method.
const MOST_WAITING: u32 = 64;

/// Both methods with their scratch; one takes the step that begins.
pub struct MethodPair {
    explicit: RungeKutta,
    stiff: Rosenbrock,
    is_stiff: bool,
    /// Sizes of Rosenbrock steps; none without error control.
    stiff_size: Option<StepSize>,
    /// Whether this Rosenbrock step is an attempt to resume the method after explicit steps.
    resumes: bool,
    /// Explicit steps since the last such attempt, and those to take before the next. The latter
    /// doubles with each failure.
    waited: u32,
    wait: u32,
}

impl MethodPair {
    /// For vectors of length `n` and steps of the explicit method sized by `size`.
    pub fn new(method: &'static Tableau, n: usize, size: &StepSize) -> Self {
        let stiff_size = match *size {
            StepSize::Fixed(_) => None,
            StepSize::Controlled { relative, absolute, max_step, .. } => {
                let (control, h) = (StepControl::new(3), FIRST.min(max_step));
                Some(StepSize::Controlled { control, relative, absolute, max_step, h })
            }
        };
        MethodPair {
            explicit: RungeKutta::new(method, n),
            stiff: Rosenbrock::new(n),
            is_stiff: false,
            stiff_size,
            resumes: false,
            waited: 0,
            wait: 1,
        }
    }

    /// Resets the size of stiff steps after a jump of the equations.
    pub fn restart(&mut self) {
        if let Some(StepSize::Controlled { max_step, h, .. }) = &mut self.stiff_size {
            *h = FIRST.min(*max_step);
        }
    }

    /// Evaluates the start of a step.
    pub fn begin(&mut self, plant: &mut Plant, t: f64, y: &[f64]) {
        self.explicit.begin(plant, t, y);
        self.is_stiff = false;
    }

    /// Selects the method of the step that begins, whose explicit size would be `h`. Returns the
    /// size of its first attempt.
    pub fn select(&mut self, plant: &mut Plant, y: &[f64], h: f64, remaining: f64) -> f64 {
        let Some(size) = &self.stiff_size else { return h };
        let stiff = size.next(remaining);
        let can_resume = self.waited >= self.wait;
        self.waited = self.waited.saturating_add(1);
        let estimate = plant.friction_rate_estimate();
        if !(estimate > 0.0) || estimate < MODERATE && h > SHORT {
            return h;
        }
        plant.friction_stiffness(&mut self.stiff.stiff);
        let limit = STABLE / self.stiff.stiff.rate();
        // Size of a Rosenbrock step: the one stored, or, after a transient in which explicit steps
        // were the longer ones, twice their limit once they have reached it.
        let resumes = !(limit <= stiff);
        if resumes && !(can_resume && h > 0.5 * limit) {
            return h;
        }
        let first = if resumes { (2.0 * limit).min(remaining) } else { stiff };
        self.stiff.begin(y, self.explicit.slope());
        (self.is_stiff, self.resumes) = (true, resumes);
        first
    }

    /// Whether the Rosenbrock method takes this step.
    pub fn is_stiff(&self) -> bool {
        self.is_stiff
    }

    /// Tries a step of size `h`; the system is left at its end.
    pub fn attempt(&mut self, plant: &mut Plant, t: f64, h: f64) {
        match self.is_stiff {
            true => self.stiff.attempt(plant, t, h),
            false => self.explicit.attempt(plant, t, h),
        }
    }

    /// None if the error of the attempted step is acceptable; else the factor to shorten it by.
    pub fn shorten(&mut self, size: &mut StepSize, layout: &StateLayout, h: f64, remaining: f64) -> Option<f64> {
        let (explicit, stiff) = (&self.explicit, &self.stiff);
        match &mut self.stiff_size {
            Some(size) if self.is_stiff => {
                let factor = size.shorten(|tolerances| stiff.error(tolerances, layout.error_groups()), h, remaining);
                if std::mem::take(&mut self.resumes) {
                    self.waited = 0;
                    self.wait = if factor.is_some() { (2 * self.wait).min(MOST_WAITING) } else { 1 };
                }
                factor
            }
            _ => size.shorten(|tolerances| explicit.error(tolerances, layout.error_groups()), h, remaining),
        }
    }

    /// As [`shorten`](Self::shorten) for a step that has been repeated to end at an event. The size
    /// of the next step does not change.
    pub fn shorten_located(&self, size: &StepSize, layout: &StateLayout) -> Option<f64> {
        let error = |tolerances| match self.is_stiff {
            true => self.stiff.error(tolerances, layout.error_groups()),
            false => self.explicit.error(tolerances, layout.error_groups()),
        };
        self.stiff_size.as_ref().filter(|_| self.is_stiff).unwrap_or(size).shorten_located(error)
    }

    /// Solution at the end of the last attempt.
    pub fn end(&self) -> &[f64] {
        if self.is_stiff { &self.stiff.end } else { &self.explicit.end }
    }

    /// Dense output at the fraction `theta` of the last attempt.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        match self.is_stiff {
            true => self.stiff.interpolate(theta, out),
            false => self.explicit.interpolate(theta, out),
        }
    }
}
