//! An explicit Runge-Kutta method and a Rosenbrock method for steps in which friction or other forces are stiff.
//!
//! Friction of a slow vertex turns with its direction at rates that grow without bound as its speed
//! goes to zero ([`crate::sim::plant::friction_stiffness`]). Explicit steps are then limited by
//! stability, not by accuracy. Where that limit is below the step that the Rosenbrock method takes,
//! the latter takes it. The rate is computed where an estimate is high, or explicit steps are so
//! short that something limits them.
//!
//! Drives, springs and dampers ([`crate::sim::plant::implicit_forces`]) are implicit in all steps, in none, or in those
//! after stability has limited explicit ones, until accuracy would limit them too ([`ImplicitSteps`]). Explicit steps
//! are limited by stability where `h |lambda|` is near the limit in [`STIFF_STEPS`] steps, with the estimate of [Hairer 1996],
//! section IV.2, from the two stages at the end of a step,
//!
//! ```text
//! |lambda| = |f(t + h, y1) - f(t + h, Y_6)| / |y1 - Y_6|
//! ```
//!
//! Steps in which friction alone is implicit are limited by the forces where h times a bound of their rates is.

use super::step_size::StepSize;
use crate::integrate::{Rosenbrock, RungeKutta, StepControl, StiffSolver, Tableau};
use crate::sim::plant::Plant;
use crate::sim::plant::friction_stiffness::MOST_VERTICES;
use crate::sim::plant::implicit_forces::ImplicitForces;
use crate::sim::plant::state_layout::StateLayout;
use crate::sim::setup::ImplicitSteps;

/// Product of step and eigenvalue up to which explicit steps are stable (`dopri5`: 3.3).
const STABLE: f64 = 3.0;
/// Estimated rate of friction up to which explicit steps are not limited noticeably, 1/s.
const MODERATE: f64 = 1e5;
/// Size of explicit steps up to which friction may limit them although the estimate is moderate, s.
const SHORT: f64 = 1e-5;
/// First step of the Rosenbrock method after a restart, s.
const FIRST: f64 = 1e-4;
/// Estimate of `h |lambda|` above which an explicit step counts as limited by stability.
const LIMITED: f64 = 2.5;
/// Number of such steps after which forces become implicit, less one for each six that are not.
const STIFF_STEPS: u32 = 12;
/// Product of a step and the rate of the implicit forces below which explicit steps resume. It is below
/// [`LIMITED`], so that stability does not limit them; a step of the Rosenbrock method costs no more than one
/// of them.
const EASY: f64 = 2.0;
/// The same on a compliant floor, whose springs are many and change: such steps cost three of them.
const EASY_ON_SPRINGS: f64 = 10.0;
/// The same where friction is stiff too: its steps cost as much without the forces.
const EASY_WITH_FRICTION: f64 = 0.5;
/// Product of a step with friction alone and the rate of the forces above which these may limit it. Such steps are
/// stable to less than explicit ones.
const LIMITED_WITH_FRICTION: f64 = 1.0;
/// Number of such steps after which forces become explicit again.
const EASY_STEPS: u32 = 12;
/// Factor by which [`STIFF_STEPS`] grows at most, doubling each time that forces were implicit for less than
/// [`SHORT_STAY`] steps.
const MOST_RELUCTANT: u32 = 32;
/// Number of steps with implicit forces after which the change to them has paid.
const SHORT_STAY: u32 = 100;
/// Number of steps for which responses to forces are kept.
const KEPT: u32 = 12;
/// Product of a step and the estimated rate of friction above which friction is implicit with the others.
const TOGETHER: f64 = 0.3;
/// First step after a restart with implicit forces, s.
const FIRST_OF_FORCES: f64 = 1e-3;
/// Most explicit steps between two attempts to resume the Rosenbrock method.
const MOST_WAITING: u32 = 64;

/// Both methods with their scratch; one takes the step that begins.
#[derive(Clone)]
pub struct MethodPair {
    explicit: RungeKutta,
    stiff: Rosenbrock,
    /// Linear systems of its steps.
    solver: StiffSolver,
    is_stiff: bool,
    /// Sizes of Rosenbrock steps; none without error control.
    stiff_size: Option<StepSize>,
    /// Whether this Rosenbrock step is an attempt to resume the method after explicit steps.
    resumes: bool,
    /// Explicit steps since the last such attempt, and those to take before the next. The latter
    /// doubles with each failure.
    waited: u32,
    wait: u32,
    implicit: Implicit,
}

/// The implicit forces.
#[derive(Clone)]
struct Implicit {
    forces: ImplicitForces,
    choice: ImplicitSteps,
    /// Whether they are implicit in the next step.
    are_implicit: bool,
    /// Product of a step and their rate below which explicit steps resume.
    easy: f64,
    /// Steps that count towards the next change.
    count: u32,
    /// Accepted steps with implicit forces since the last change.
    stay: u32,
    /// Present factor of [`STIFF_STEPS`].
    reluctance: u32,
    /// Steps since the last that did not count.
    others: u32,
    /// Accepted steps with implicit friction alone since the rates of the forces were last compared with them.
    of_friction: u32,
    /// Whether friction is implicit with them.
    has_friction: bool,
    /// Steps since their responses were computed.
    age: u32,
    /// Upper bound of their rates, 1/s.
    rate: f64,
}

impl MethodPair {
    /// For a plant, and steps of the explicit method sized by `size`.
    pub fn new(method: &'static Tableau, plant: &Plant, size: &StepSize, choice: ImplicitSteps) -> Self {
        let n = plant.layout.size();
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
            solver: StiffSolver::new(n, MOST_VERTICES),
            is_stiff: false,
            stiff_size,
            resumes: false,
            waited: 0,
            wait: 1,
            implicit: Implicit {
                forces: ImplicitForces::default(),
                choice,
                are_implicit: choice == ImplicitSteps::Always,
                easy: if plant.is_compliant() { EASY_ON_SPRINGS } else { EASY },
                count: 0,
                stay: 0,
                reluctance: 1,
                others: 0,
                of_friction: 0,
                has_friction: false,
                age: 0,
                rate: 0.0,
            },
        }
    }

    /// Resets the size of stiff steps after a jump of the equations.
    pub fn restart(&mut self) {
        self.begin_stiff_steps(if self.implicit.are_implicit { FIRST_OF_FORCES } else { FIRST });
        self.implicit.age = KEPT;
    }

    /// Evaluates the start of a step.
    pub fn begin(&mut self, plant: &mut Plant, t: f64, y: &[f64]) {
        self.explicit.begin(plant, t, y);
        self.is_stiff = false;
    }

    /// The same where the last evaluation was at `y`.
    pub fn begin_evaluated(&mut self, plant: &Plant, y: &[f64]) {
        self.explicit.begin_with(y, |slope| plant.write_derivative(y, slope));
        self.is_stiff = false;
    }

    /// Selects the method of the step that begins, whose explicit size would be `h`. Returns the
    /// size of its first attempt. `is_new`: the equations may have changed since the last step.
    pub fn select(&mut self, plant: &mut Plant, y: &[f64], h: f64, remaining: f64, is_new: bool) -> f64 {
        let Some(size) = &self.stiff_size else { return h };
        let stiff = size.next(remaining);
        if self.implicit.must_compare() {
            self.use_forces(plant, stiff, true);
            self.implicit.compare(stiff);
        }
        if self.implicit.are_implicit {
            self.use_forces(plant, stiff, is_new);
            self.stiff.begin(y, self.explicit.slope());
            (self.is_stiff, self.resumes) = (true, false);
            return stiff;
        }
        let can_resume = self.waited >= self.wait;
        self.waited = self.waited.saturating_add(1);
        let estimate = plant.friction_rate_estimate();
        if !(estimate > 0.0) || estimate < MODERATE && h > SHORT {
            return h;
        }
        self.solver.stiff.clear();
        plant.friction_stiffness(&mut self.solver.stiff);
        self.solver.stiff.complete();
        let limit = STABLE / self.solver.stiff.rate();
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

    /// Makes the implicit forces the stiff part of a step of size `h`, with friction if that is stiff.
    fn use_forces(&mut self, plant: &mut Plant, h: f64, is_new: bool) {
        let implicit = &mut self.implicit;
        let renew = implicit.forces.find(plant) || is_new || implicit.age >= KEPT;
        if renew {
            // Forces and polygons of the floor may be others now.
            self.solver.reserve(implicit.forces.most_products(plant) + MOST_VERTICES);
            implicit.forces.renew(plant, &mut self.solver.stiff);
        }
        let stiff = &mut self.solver.stiff;
        implicit.forces.write(plant, stiff);
        implicit.age = if renew { 0 } else { implicit.age + 1 };
        let mut is_complete = false;
        if renew && implicit.choice == ImplicitSteps::Auto {
            stiff.complete();
            implicit.rate = stiff.rate_bound();
            is_complete = true;
        }
        implicit.has_friction = plant.friction_rate_estimate() * h > TOGETHER;
        if implicit.has_friction {
            plant.friction_stiffness(stiff);
            is_complete = false;
        }
        if !is_complete {
            stiff.complete();
        }
    }

    /// Whether forces are implicit in the next step.
    pub fn has_implicit_forces(&self) -> bool {
        self.implicit.are_implicit
    }

    /// Whether the Rosenbrock method takes this step.
    pub fn is_stiff(&self) -> bool {
        self.is_stiff
    }

    /// Tries a step of size `h`. Explicit steps leave the system at its end.
    pub fn attempt(&mut self, plant: &mut Plant, t: f64, h: f64) {
        match self.is_stiff {
            true => self.stiff.attempt(&mut self.solver, plant, t, h),
            false => self.explicit.attempt(plant, t, h),
        }
    }

    /// None if the error of the attempted step is acceptable; else the factor to shorten it by.
    pub fn shorten(&mut self, size: &mut StepSize, layout: &StateLayout, h: f64, remaining: f64) -> Option<f64> {
        let (explicit, stiff) = (&self.explicit, &self.stiff);
        match &mut self.stiff_size {
            Some(size) if self.is_stiff => {
                let factor = size.shorten(|tolerances| stiff.error(tolerances, layout.error_groups()), h, remaining);
                if self.implicit.are_implicit {
                    self.implicit.count_implicit(factor.is_some(), size.next(f64::INFINITY));
                    return factor;
                }
                self.implicit.of_friction += u32::from(factor.is_none());
                if std::mem::take(&mut self.resumes) {
                    self.waited = 0;
                    self.wait = if factor.is_some() { (2 * self.wait).min(MOST_WAITING) } else { 1 };
                }
                factor
            }
            _ => {
                let factor = size.shorten(|tolerances| explicit.error(tolerances, layout.error_groups()), h, remaining);
                if factor.is_none() && self.implicit.choice == ImplicitSteps::Auto {
                    let rate = self.explicit.rate_estimate(layout.controlled());
                    if self.implicit.count_explicit(rate.map_or(0.0, |rate| h * rate)) {
                        self.begin_stiff_steps(h);
                    }
                }
                factor
            }
        }
    }

    /// Sets the size of the next step of the Rosenbrock method.
    fn begin_stiff_steps(&mut self, size: f64) {
        if let Some(StepSize::Controlled { max_step, h, .. }) = &mut self.stiff_size {
            *h = size.min(*max_step);
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

    /// Moves the end of the last attempt of a Rosenbrock step to the plant's state.
    pub fn move_end(&mut self, plant: &Plant) {
        let flows = plant.layout.flows(&self.stiff.end);
        plant.pack(&flows, &mut self.stiff.end);
    }

    /// Dense output at the fraction `theta` of the last attempt.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        match self.is_stiff {
            true => self.stiff.interpolate(theta, out),
            false => self.explicit.interpolate(theta, out),
        }
    }
}

impl Implicit {
    /// Counts an accepted explicit step with this estimate of `h |lambda|`. Returns whether the forces have become
    /// implicit.
    fn count_explicit(&mut self, product: f64) -> bool {
        if product > LIMITED {
            (self.count, self.others) = (self.count + 1, 0);
        } else {
            self.others += 1;
            if self.others.is_multiple_of(6) {
                self.count = self.count.saturating_sub(1);
            }
        }
        self.are_implicit = self.count >= STIFF_STEPS * self.reluctance;
        if self.are_implicit {
            (self.count, self.stay, self.age) = (0, 0, KEPT);
        }
        self.are_implicit
    }

    /// Whether steps with implicit friction alone may be limited by the forces: the stages of such steps give no
    /// estimate of `h |lambda|`.
    fn must_compare(&self) -> bool {
        self.choice == ImplicitSteps::Auto && !self.are_implicit && self.of_friction >= STIFF_STEPS * self.reluctance
    }

    /// Makes the forces implicit if their rates limit steps of this size.
    fn compare(&mut self, size: f64) {
        self.of_friction = 0;
        if size * self.rate > LIMITED_WITH_FRICTION {
            (self.are_implicit, self.count, self.stay, self.age) = (true, 0, 0, KEPT);
        }
    }

    /// Counts a step with implicit forces, after which the next one has size `next`.
    fn count_implicit(&mut self, is_rejected: bool, next: f64) {
        if is_rejected {
            self.age = KEPT;
            return;
        }
        self.stay = self.stay.saturating_add(1);
        let easy = if self.has_friction { EASY_WITH_FRICTION } else { self.easy };
        self.count = if next * self.rate < easy { self.count + 1 } else { 0 };
        if self.count >= EASY_STEPS && self.choice == ImplicitSteps::Auto {
            let is_short = self.stay < SHORT_STAY;
            self.reluctance = if is_short { (2 * self.reluctance).min(MOST_RELUCTANT) } else { 1 };
            (self.count, self.others, self.are_implicit) = (0, 0, false);
        }
    }
}
