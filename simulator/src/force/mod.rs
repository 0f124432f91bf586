//! External force models: the trait [`Force`] and its implementations, one file each.
//!
//! As in section II.C of the paper, a model is initialised once and then evaluated at any time and
//! state that the adaptive integrator visits. It gives in advance the times at which it is not
//! smooth, so that steps end there.
//!
//! Imports: `math`, `random`, `robot`, `dynamics`, `motion`. Used by: `script`, `sim`, `assemble`.

pub mod anchor;
pub mod drag;
mod force_error;
pub mod friction;
pub mod on_object;
pub mod profile;
pub mod random_pushes;
pub mod spring;
pub mod wrench;

pub use force_error::ForceError;

use crate::dynamics::{State, Workspace};
use crate::robot::{LinkId, Model};
use nalgebra::{Matrix3, Vector3};
use std::any::Any;

/// The instant at which forces are evaluated.
pub struct ForceContext<'a> {
    /// The robot, or the object that the model acts on.
    pub model: &'a Model,
    /// Positions and velocities.
    pub state: &'a State,
    /// Kinematics at that state.
    pub kinematics: &'a Workspace,
    /// Free fall in world axes, m/s^2.
    pub gravity: Vector3<f64>,
    /// Time, s.
    pub time: f64,
    /// A time inside the smooth piece being integrated: shows on which side of a discontinuity
    /// `time` is.
    pub within: f64,
}

impl ForceContext<'_> {
    /// Rotation of a link's internal frame and position of its origin, world.
    pub fn frame(&self, link: LinkId) -> (Matrix3<f64>, Vector3<f64>) {
        let l = &self.kinematics.links[link.0];
        (l.rotation, l.origin + self.kinematics.position)
    }
}

/// Sum of the forces of one instant.
pub struct AppliedForces<'a> {
    tau: &'a mut [f64],
    arrows: &'a mut Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl<'a> AppliedForces<'a> {
    /// Adds to the generalised force `tau` (nv) and lists force arrows (world point, force) in
    /// `arrows`.
    pub fn new(tau: &'a mut [f64], arrows: &'a mut Vec<(Vector3<f64>, Vector3<f64>)>) -> Self {
        AppliedForces { tau, arrows }
    }

    /// Adds a force (N) at a world point (m) of a link and a moment (N m), world axes.
    pub fn wrench(
        &mut self,
        context: &ForceContext,
        link: LinkId,
        point: &Vector3<f64>,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
    ) {
        crate::dynamics::link_force::accumulate(context.kinematics, link, point, force, moment, self.tau);
        if *force != Vector3::zeros() {
            self.arrows.push((*point, *force));
        }
    }

    /// Adds an effort (N m or N) on a joint.
    pub fn joint(&mut self, model: &Model, joint: usize, effort: f64) {
        self.tau[model.nb() + joint] += effort;
    }
}

/// Decrease of the force on a point of a link per change of the point's velocity.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Damper {
    /// The link.
    pub link: LinkId,
    /// The point, world, m.
    pub point: Vector3<f64>,
    /// The coefficient, N s/m, not negative.
    pub coefficient: f64,
}

/// How a force changes with the state, for integrators that take it implicitly.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Slope {
    /// The effort on a joint decreases by `damping` per change of its velocity, N m s or N s/m.
    Joint {
        /// The joint.
        joint: usize,
        /// The decrease.
        damping: f64,
    },
    /// The force on a point of a link decreases by `stiffness` per displacement of the point, N/m, and by that of
    /// the damper per change of its velocity. World axes.
    Point {
        /// The point, and its damping.
        damper: Damper,
        /// The decrease per displacement.
        stiffness: Matrix3<f64>,
        /// Rate of the force at a fixed state, N/s.
        by_time: Vector3<f64>,
    },
}

/// Receives an event of a force model: kind, subject and message.
pub type ReportEvent<'a> = dyn FnMut(&'static str, &str, String) + 'a;

/// An external force model.
pub trait Force: Any + Send {
    /// Called first on a model that replaces `former` during the run, at `time`. Events that
    /// `former` has reported, or that are over, are not reported again.
    fn continue_from(&mut self, _former: &dyn Any, _time: f64) {}

    /// The mechanism that it acts on: 0 for the robot, n + 1 for object n. Contexts are those of it.
    fn mechanism(&self) -> usize {
        0
    }

    /// Greatest number of force arrows at one instant; room for them is allocated before the run.
    /// Scripts cannot know it.
    fn arrows(&self) -> usize {
        1
    }

    /// Called once at the start of the run, before any evaluation.
    ///
    /// # Errors
    /// The model cannot start; the run ends with outcome `error`.
    fn init(&mut self, _context: &ForceContext) -> Result<(), ForceError> {
        Ok(())
    }

    /// Called at the start of the run and at each corner of any force model, before any evaluation
    /// beyond it. The time never decreases between two such calls.
    fn on_corner(&mut self, _context: &ForceContext, _report: &mut ReportEvent) {}

    /// Adds its forces at this instant, which may be before or after that of the last call.
    /// Allocates nothing.
    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces);

    /// Adds to `out` (nv) the decrease of its generalised force per change of each velocity, N s/m
    /// or N m s; not negative. Velocity-level steps apply it at the end of the step: the forces
    /// could otherwise reverse a motion within one step.
    fn damping(&self, _context: &ForceContext, _out: &mut [f64]) {}

    /// Calls `damper` for each damper between a point of a link and the surroundings: like
    /// [`damping`](Self::damping), but equal in all directions.
    fn dampers(&self, _context: &ForceContext, _damper: &mut dyn FnMut(Damper)) {}

    /// Calls `each` for each slope of its forces at this instant, which need not be exact. The defaults are those of
    /// the dampers.
    fn slopes(&self, context: &ForceContext, each: &mut dyn FnMut(Slope)) {
        let (stiffness, by_time) = (Matrix3::zeros(), Vector3::zeros());
        self.dampers(context, &mut |damper| each(Slope::Point { damper, stiffness, by_time }));
    }

    /// Corners: times at which its value or slope is discontinuous, s.
    fn corners(&self) -> &[f64] {
        &[]
    }

    /// Whether its forces depend on earlier calls, so that a run cannot return to an earlier state.
    fn has_memory(&self) -> bool {
        false
    }

    /// The error of a failed evaluation; the run then ends with outcome `error`.
    fn failure(&self) -> Option<ForceError> {
        None
    }
}

/// Placeholder for an entry that exerts no force, such as a carried object.
pub struct NoForce;

impl Force for NoForce {
    fn evaluate(&mut self, _: &ForceContext, _: &mut AppliedForces) {}
}
