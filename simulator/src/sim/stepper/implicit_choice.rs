//! When drives, springs and dampers ([`crate::sim::plant::implicit_forces`]) are implicit: in all steps, in none, or
//! in those after stability has limited explicit ones, until accuracy would limit them too ([`ImplicitSteps`]).
//!
//! Explicit steps are limited by stability where `h |lambda|` is near the limit in [`STIFF_STEPS`] steps, with the
//! estimate of [Hairer 1996], section IV.2, from the two stages at the end of a step,
//!
//! ```text
//! |lambda| = |f(t + h, y1) - f(t + h, Y_6)| / |y1 - Y_6|
//! ```
//!
//! Steps in which friction alone is implicit are limited by the forces where h times a bound of their rates is.

use crate::integrate::StiffSolver;
use crate::sim::plant::Plant;
use crate::sim::plant::friction_stiffness::MOST_VERTICES;
use crate::sim::plant::implicit_forces::ImplicitForces;
use crate::sim::setup::ImplicitSteps;

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

/// The implicit forces, and whether the next step has them.
#[derive(Clone)]
pub struct ImplicitChoice {
    forces: ImplicitForces,
    /// As the setup says.
    pub steps: ImplicitSteps,
    /// Whether they are implicit in the next step.
    pub are_implicit: bool,
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
    pub of_friction: u32,
    /// Whether friction is implicit with them.
    has_friction: bool,
    /// Steps since their responses were computed.
    age: u32,
    /// Upper bound of their rates, 1/s.
    rate: f64,
}

impl ImplicitChoice {
    /// For a plant.
    pub fn new(steps: ImplicitSteps, plant: &Plant) -> Self {
        ImplicitChoice {
            forces: ImplicitForces::default(),
            steps,
            are_implicit: matches!(steps, ImplicitSteps::Rosenbrock | ImplicitSteps::Bdf),
            easy: if plant.is_compliant() { EASY_ON_SPRINGS } else { EASY },
            count: 0,
            stay: 0,
            reluctance: 1,
            others: 0,
            of_friction: 0,
            has_friction: false,
            age: 0,
            rate: 0.0,
        }
    }

    /// Forgets the responses to the forces, after a jump of the equations.
    pub fn restart(&mut self) {
        self.age = KEPT;
    }

    /// Makes the forces the stiff part of a step of size `h`, with friction if that is stiff. `is_new`: the equations
    /// may have changed since the last step.
    pub fn write(&mut self, plant: &mut Plant, solver: &mut StiffSolver, h: f64, is_new: bool) {
        let renew = self.forces.find(plant) || is_new || self.age >= KEPT;
        if renew {
            // Forces and polygons of the floor may be others now.
            solver.reserve(self.forces.most_products(plant) + MOST_VERTICES);
            self.forces.renew(plant, &mut solver.stiff);
        }
        let stiff = &mut solver.stiff;
        self.forces.write(plant, stiff);
        self.age = if renew { 0 } else { self.age + 1 };
        let mut is_complete = false;
        if renew && self.steps == ImplicitSteps::Auto {
            stiff.complete();
            self.rate = stiff.rate_bound();
            is_complete = true;
        }
        self.has_friction = plant.friction_rate_estimate() * h > TOGETHER;
        if self.has_friction {
            plant.friction_stiffness(stiff);
            is_complete = false;
        }
        if !is_complete {
            stiff.complete();
        }
    }

    /// Counts an accepted explicit step with this estimate of `h |lambda|`. Returns whether the forces have become
    /// implicit.
    pub fn count_explicit(&mut self, product: f64) -> bool {
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
    pub fn must_compare(&self) -> bool {
        self.steps == ImplicitSteps::Auto && !self.are_implicit && self.of_friction >= STIFF_STEPS * self.reluctance
    }

    /// Makes the forces implicit if their rates limit steps of this size.
    pub fn compare(&mut self, size: f64) {
        self.of_friction = 0;
        if size * self.rate > LIMITED_WITH_FRICTION {
            (self.are_implicit, self.count, self.stay, self.age) = (true, 0, 0, KEPT);
        }
    }

    /// Counts a step with implicit forces, after which the next one has size `next`.
    pub fn count_implicit(&mut self, is_rejected: bool, next: f64) {
        if is_rejected {
            self.age = KEPT;
            return;
        }
        self.stay = self.stay.saturating_add(1);
        let easy = if self.has_friction { EASY_WITH_FRICTION } else { self.easy };
        self.count = if next * self.rate < easy { self.count + 1 } else { 0 };
        if self.count >= EASY_STEPS && self.steps == ImplicitSteps::Auto {
            let is_short = self.stay < SHORT_STAY;
            self.reluctance = if is_short { (2 * self.reluctance).min(MOST_RELUCTANT) } else { 1 };
            (self.count, self.others, self.are_implicit) = (0, 0, false);
        }
    }
}
