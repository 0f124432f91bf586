//! The methods that take steps with events: an explicit Runge-Kutta method, a Rosenbrock method where friction or other
//! forces are stiff, and backward differentiation formulas where motion with stiff forces is smooth.
//!
//! Friction of a slow vertex turns with its direction at rates that grow without bound as its speed
//! goes to zero ([`crate::sim::plant::friction_stiffness`]). Explicit steps are then limited by
//! stability, not by accuracy. Where that limit is below the step that the Rosenbrock method takes,
//! the latter takes it. The rate is computed where an estimate is high, or explicit steps are so
//! short that something limits them.
//!
//! In steps with other implicit forces ([`super::implicit_choice`]) the Rosenbrock method also takes the first ones
//! after each jump or event. From as many as the formulas need on, these take over, unless
//! [`ImplicitSteps::Rosenbrock`] leaves all to it. It takes over again for a step that the formulas have failed
//! [`MOST_FAILURES`] times, or for which one Newton iteration was not enough ([`CONVERGED`]).

use super::Discontinuity;
use super::implicit_choice::ImplicitChoice;
use super::step_size::StepSize;
use crate::integrate::{Bdf, Rosenbrock, RungeKutta, StepControl, StiffSolver, Tableau};
use crate::math;
use crate::sim::plant::Plant;
use crate::sim::plant::friction_stiffness::MOST_VERTICES;
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
/// First step after a restart with implicit forces, s.
const FIRST_OF_FORCES: f64 = 1e-3;
/// Most explicit steps between two attempts to resume the Rosenbrock method.
const MOST_WAITING: u32 = 64;
/// Attempts of one step that fail before the Rosenbrock method takes it.
const MOST_FAILURES: u32 = 2;
/// Error, in units of the tolerance, above which the motion is not smooth.
const KINK: f64 = 1e3;
/// Evaluations of a Rosenbrock step over those of a step of the formulas, which explicit steps must therefore exceed by
/// more to pay.
const CHEAPER: f64 = 2.0;
/// Part of the last Rosenbrock step below which that method takes over: its own steps cost less, and where errors are
/// those of rounding, shorter steps do not reduce them.
const SHORTEST: f64 = 0.2;
/// Least number of Rosenbrock steps after the formulas have failed. It doubles with each failure, up to the second
/// number, until they have taken [`LONG_STAY`] steps.
const RELUCTANCE: (usize, usize) = (8, 64);
const LONG_STAY: i32 = 20;
/// Greatest change by another Newton iteration, in units of the tolerance.
const CONVERGED: f64 = 0.5;
/// Factor by which a step is then shorter.
const UNSOLVED: f64 = 0.5;

/// Part of the tolerances that the formulas have, whose error estimate is that of their solution. The estimate of
/// `dopri5` is of a solution of lower order than the one it continues with; with this part both have similar errors.
const SHARE: f64 = 0.002;
/// The first steps have a greater part, less by this factor from one to the next: the points before them have errors of
/// the whole tolerance.
const TIGHTENING: f64 = 0.4;
/// Least tolerances of the formulas, relative and absolute, unless they are given lower: differences of rounded points
/// are of no use below.
const LEAST: (f64, f64) = (1e-11, 1e-12);

/// Where a step begins.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StepStart {
    /// Where the equations may have changed.
    New,
    /// At a jump of commands.
    Jump,
    /// In smooth motion where the equations may have changed.
    Renewed,
    /// In smooth motion.
    Smooth,
}

impl StepStart {
    /// At the time of the plant, after this discontinuity. `is_fresh`: contact states have been chosen; `is_smooth`: on
    /// a compliant floor, which has none, the last step has ended without an event.
    pub fn new(discontinuity: Discontinuity, is_fresh: bool, is_smooth: bool, plant: &Plant) -> Self {
        // Motion commanded from here on may continue with its accelerations.
        let is_joined = plant.kinematic_paths.are_joined(plant.state.time);
        let jumps = discontinuity == Discontinuity::Tick && !is_joined;
        match discontinuity {
            Discontinuity::Corner => StepStart::New,
            _ if is_fresh && is_smooth && !jumps => StepStart::Renewed,
            _ if is_fresh => StepStart::New,
            _ if jumps => StepStart::Jump,
            _ => StepStart::Smooth,
        }
    }
}

/// The methods with their scratch; one takes the step that begins.
#[derive(Clone)]
pub struct StepMethods {
    explicit: RungeKutta,
    rosenbrock: Rosenbrock,
    bdf: Bdf,
    /// The latest point of the formulas.
    point: Vec<f64>,
    /// Linear systems of the last two.
    solver: StiffSolver,
    active: Method,
    /// Failed attempts of the formulas in this step.
    failures: u32,
    /// Size of the last Rosenbrock step before those of the formulas, s.
    before: f64,
    /// Rosenbrock steps since the formulas have failed, and those to take before they are used again.
    since_failure: usize,
    reluctance: usize,
    /// Sizes of implicit steps; none without error control.
    stiff_size: Option<StepSize>,
    /// Whether this Rosenbrock step is an attempt to resume the method after explicit steps.
    resumes: bool,
    /// Explicit steps since the last such attempt, and those to take before the next. The latter
    /// doubles with each failure.
    waited: u32,
    wait: u32,
    implicit: ImplicitChoice,
}

/// The method that takes a step.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Method {
    Explicit,
    Rosenbrock,
    Bdf,
}

impl StepMethods {
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
        StepMethods {
            explicit: RungeKutta::new(method, n),
            rosenbrock: Rosenbrock::new(n),
            bdf: Bdf::new(n),
            point: vec![0.0; n],
            solver: StiffSolver::new(n, MOST_VERTICES),
            active: Method::Explicit,
            failures: 0,
            before: 0.0,
            since_failure: 0,
            reluctance: 0,
            stiff_size,
            resumes: false,
            waited: 0,
            wait: 1,
            implicit: ImplicitChoice::new(choice, plant),
        }
    }

    /// Resets the size of implicit steps after a jump of the equations.
    pub fn restart(&mut self) {
        self.begin_stiff_steps(if self.implicit.are_implicit { FIRST_OF_FORCES } else { FIRST });
        self.implicit.restart();
        self.bdf.clear();
    }

    /// Forgets the points of the formulas, which a step by other means or a choice of states follows.
    pub fn interrupt(&mut self) {
        self.bdf.clear();
    }

    /// Evaluates the start of a step.
    pub fn begin(&mut self, plant: &mut Plant, t: f64, y: &[f64]) {
        self.explicit.begin(plant, t, y);
        self.active = Method::Explicit;
    }

    /// The same where the last evaluation was at `y`.
    pub fn begin_evaluated(&mut self, plant: &Plant, y: &[f64]) {
        self.explicit.begin_with(y, |slope| plant.write_derivative(y, slope));
        self.active = Method::Explicit;
    }

    /// Selects the method of the step that begins, whose explicit size would be `h`. Returns the
    /// size of its first attempt.
    pub fn select(&mut self, plant: &mut Plant, y: &[f64], h: f64, remaining: f64, start: StepStart) -> f64 {
        let Some(size) = &self.stiff_size else { return h };
        let stiff = size.next(remaining);
        if self.implicit.must_compare() {
            self.implicit.write(plant, &mut self.solver, stiff, true);
            self.implicit.compare(stiff);
        }
        if self.implicit.are_implicit {
            let is_smooth = self.plan_smooth_step(plant, y, start);
            let stiff = self.stiff_size.as_ref().map_or(stiff, |size| size.next(remaining));
            self.implicit.write(plant, &mut self.solver, stiff, matches!(start, StepStart::New | StepStart::Renewed));
            self.rosenbrock.begin(y, self.explicit.slope());
            (self.active, self.resumes) = (if is_smooth { Method::Bdf } else { Method::Rosenbrock }, false);
            return stiff;
        }
        self.bdf.clear();
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
        self.rosenbrock.begin(y, self.explicit.slope());
        (self.active, self.resumes) = (Method::Rosenbrock, resumes);
        first
    }

    /// Adds the start of a step to the points of the formulas. Returns whether these take it, with its size planned.
    fn plan_smooth_step(&mut self, plant: &Plant, y: &[f64], start: StepStart) -> bool {
        if self.implicit.steps == ImplicitSteps::Rosenbrock {
            return false;
        }
        if matches!(start, StepStart::New | StepStart::Jump) {
            self.bdf.clear();
        }
        self.point.copy_from_slice(y);
        plant.hold_prescribed(&mut self.point);
        self.bdf.add_point(plant.state.time, &self.point);
        self.since_failure += 1;
        self.failures = 0;
        if !self.bdf.is_ready() || self.since_failure < self.reluctance {
            return false;
        }
        let tolerances = self.smooth_tolerances();
        let Some(StepSize::Controlled { max_step, h, .. }) = &mut self.stiff_size else { return false };
        if self.bdf.taken() == 0 {
            self.before = *h;
        } else if self.bdf.taken() >= LONG_STAY {
            self.reluctance = 0;
        }
        let planned = self.bdf.plan(tolerances, || plant.layout.error_groups(), *max_step);
        if planned < SHORTEST * self.before {
            self.leave_smooth_steps();
            return false;
        }
        *h = planned;
        true
    }

    /// Relative and absolute tolerance of the formulas.
    fn smooth_tolerances(&self) -> (f64, f64) {
        let Some(StepSize::Controlled { relative, absolute, .. }) = self.stiff_size else { return (0.0, 0.0) };
        let part = math::powi(TIGHTENING, self.bdf.taken()).max(SHARE);
        let share = |tolerance: f64, least: f64| (part * tolerance).max(least.min(tolerance));
        (share(relative, LEAST.0), share(absolute, LEAST.1))
    }

    /// Whether forces are implicit in the next step.
    pub fn has_implicit_forces(&self) -> bool {
        self.implicit.are_implicit
    }

    /// Whether this step has implicit forces or friction.
    pub fn is_stiff(&self) -> bool {
        self.active != Method::Explicit
    }

    /// Tries a step of size `h`. Explicit steps leave the system at its end.
    pub fn attempt(&mut self, plant: &mut Plant, t: f64, h: f64) {
        match self.active {
            Method::Explicit => self.explicit.attempt(plant, t, h),
            Method::Rosenbrock => self.rosenbrock.attempt(&mut self.solver, plant, t, h),
            Method::Bdf => self.bdf.attempt(&mut self.solver, plant, h),
        }
    }

    /// None if the error of the attempted step is acceptable; else the factor to shorten it by.
    pub fn shorten(&mut self, size: &mut StepSize, layout: &StateLayout, h: f64, remaining: f64) -> Option<f64> {
        let (explicit, rosenbrock) = (&self.explicit, &self.rosenbrock);
        let smooth_tolerances = self.smooth_tolerances();
        match &mut self.stiff_size {
            Some(_) if self.active == Method::Bdf => {
                let error = self.bdf.error(smooth_tolerances, layout.error_groups());
                let is_rejected = !(error <= 1.0);
                self.implicit.count_implicit(is_rejected, CHEAPER * h);
                is_rejected.then(|| self.shorten_smooth_step(error))
            }
            Some(size) if self.active == Method::Rosenbrock => {
                let factor =
                    size.shorten(|tolerances| rosenbrock.error(tolerances, layout.error_groups()), h, remaining);
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
                if factor.is_none() && self.implicit.steps == ImplicitSteps::Auto {
                    let rate = self.explicit.rate_estimate(layout.controlled());
                    if self.implicit.count_explicit(rate.map_or(0.0, |rate| h * rate)) {
                        self.begin_stiff_steps(h);
                    }
                }
                factor
            }
        }
    }

    /// Factor by which to shorten a step of the formulas after an attempt with `error`. The Rosenbrock method takes
    /// it if that was not the first, or the motion has a kink.
    fn shorten_smooth_step(&mut self, error: f64) -> f64 {
        self.failures += 1;
        if self.failures >= MOST_FAILURES || !(error < KINK) {
            self.leave_smooth_steps();
            return 1.0;
        }
        self.bdf.shorten(error)
    }

    /// Lets the Rosenbrock method take the step that has begun.
    fn leave_smooth_steps(&mut self) {
        self.bdf.clear();
        self.since_failure = 0;
        self.reluctance = (2 * self.reluctance).clamp(RELUCTANCE.0, RELUCTANCE.1);
        self.active = Method::Rosenbrock;
    }

    /// None if the solution of an accepted step, at whose end the plant is evaluated, solves the equations; else the
    /// factor to shorten it by.
    pub fn shorten_unsolved(&mut self, plant: &Plant) -> Option<f64> {
        if self.active != Method::Bdf {
            return None;
        }
        let tolerances = self.smooth_tolerances();
        let slope = |y: &[f64], slope: &mut [f64]| plant.write_derivative(y, slope);
        let groups = plant.layout.error_groups();
        let correction = self.bdf.correction(&mut self.solver, slope, tolerances, groups);
        (!(correction <= CONVERGED)).then(|| {
            self.implicit.restart();
            self.leave_smooth_steps();
            UNSOLVED
        })
    }

    /// Sets the size of the next implicit step.
    fn begin_stiff_steps(&mut self, size: f64) {
        if let Some(StepSize::Controlled { max_step, h, .. }) = &mut self.stiff_size {
            *h = size.min(*max_step);
        }
    }

    /// As [`shorten`](Self::shorten) for a step that has been repeated to end at an event. The size
    /// of the next step does not change.
    pub fn shorten_located(&self, size: &StepSize, layout: &StateLayout) -> Option<f64> {
        let error = |tolerances| match self.active {
            Method::Explicit => self.explicit.error(tolerances, layout.error_groups()),
            Method::Rosenbrock => self.rosenbrock.error(tolerances, layout.error_groups()),
            Method::Bdf => self.bdf.error(self.smooth_tolerances(), layout.error_groups()),
        };
        self.stiff_size.as_ref().filter(|_| self.is_stiff()).unwrap_or(size).shorten_located(error)
    }

    /// Solution at the end of the last attempt.
    pub fn end(&self) -> &[f64] {
        match self.active {
            Method::Explicit => &self.explicit.end,
            Method::Rosenbrock => &self.rosenbrock.end,
            Method::Bdf => &self.bdf.end,
        }
    }

    /// Moves the end of the last attempt of a Rosenbrock step to the plant's state.
    pub fn move_end(&mut self, plant: &Plant) {
        let end = if self.active == Method::Bdf { &mut self.bdf.end } else { &mut self.rosenbrock.end };
        let flows = plant.layout.flows(end);
        plant.pack(&flows, end);
    }

    /// Dense output at the fraction `theta` of the last attempt.
    pub fn interpolate(&self, theta: f64, out: &mut [f64]) {
        match self.active {
            Method::Explicit => self.explicit.interpolate(theta, out),
            Method::Rosenbrock => self.rosenbrock.interpolate(theta, out),
            Method::Bdf => self.bdf.interpolate(theta, out),
        }
    }
}
