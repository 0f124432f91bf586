//! External force models: one file each, behind one trait.
//!
//! As in the paper's section II.C a model is initialised once and then asked for its forces at any time and state that
//! the adaptive integrator visits. Models say beforehand at which times they are not smooth, so that steps end there.

pub mod anchor;
pub mod drag;
mod error;
pub mod friction;
pub mod profile;
pub mod random_pushes;
pub mod spring;
pub mod wrench;

pub use error::ForceError;

use crate::dynamics::{State, Workspace};
use crate::robot::{LinkId, Model};
use nalgebra::{Matrix3, Vector3};
use std::any::Any;

/// The instant at which forces are wanted.
pub struct ForceContext<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Positions and velocities.
    pub state: &'a State,
    /// Kinematics at that state.
    pub kinematics: &'a Workspace,
    /// Free fall in world axes, m/s^2.
    pub gravity: Vector3<f64>,
    /// Time, s.
    pub time: f64,
    /// A time inside the smooth piece being integrated: which side of a jump `time` belongs to.
    pub within: f64,
}

impl ForceContext<'_> {
    /// Rotation of a link's internal frame and position of its origin, world.
    pub fn frame(&self, link: LinkId) -> (Matrix3<f64>, Vector3<f64>) {
        let l = &self.kinematics.links[link.0];
        (l.rotation, l.origin + self.kinematics.position)
    }
}

/// Collects the forces of one instant.
pub struct AppliedForces<'a> {
    tau: &'a mut [f64],
    arrows: &'a mut Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl<'a> AppliedForces<'a> {
    /// Adds into the generalised force `tau` (nv) and lists force arrows (world point, force) in `arrows`.
    pub fn new(tau: &'a mut [f64], arrows: &'a mut Vec<(Vector3<f64>, Vector3<f64>)>) -> Self {
        AppliedForces { tau, arrows }
    }

    /// A force (N) at a world point (m) of a link and a moment (N m), world axes.
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

    /// An effort (N m or N) on a joint.
    pub fn joint(&mut self, model: &Model, joint: usize, effort: f64) {
        self.tau[model.nb() + joint] += effort;
    }
}

/// By how much a force on a point of a link falls per change of the point's velocity.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Damper {
    /// The link.
    pub link: LinkId,
    /// The point, world, m.
    pub point: Vector3<f64>,
    /// The coefficient, N s/m, not negative.
    pub coefficient: f64,
}

/// Hears what a force model has to report: kind, subject and words of an event.
pub type ReportEvent<'a> = dyn FnMut(&'static str, &str, String) + 'a;

/// An external force model.
pub trait Force: Any + Send {
    /// Called first of all on a model that takes the place of `former` while the run goes on, at `time`: what that one has
    /// told is not told again, and neither is what is over.
    fn continue_from(&mut self, _former: &dyn Any, _time: f64) {}

    /// The most forces that it lists at one instant: room is made for them before the run. A script's are not known.
    fn arrows(&self) -> usize {
        1
    }

    /// Called once at the start of the run, before anything is evaluated.
    ///
    /// # Errors
    /// In words; they end the run with outcome `error`.
    fn init(&mut self, _scene: &ForceContext) -> Result<(), ForceError> {
        Ok(())
    }

    /// Called at the start of the run and at each of the instants that are corners of any force model, before anything is
    /// evaluated beyond it: the time never goes back between two such calls.
    fn pass(&mut self, _scene: &ForceContext, _tell: &mut ReportEvent) {}

    /// Adds its forces at this instant, which may lie before or after that of the last call. Allocates nothing.
    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces);

    /// Adds to `out` (nv) by how much its generalised force falls per change of each velocity, N s/m or N m s: velocity-level
    /// steps take it at the end of the step. For forces that would else turn a motion round within one; not negative.
    fn damping(&self, _scene: &ForceContext, _out: &mut [f64]) {}

    /// Names the dampers that its forces hold between points of links and what does not follow the robot: as
    /// [`damping`](Self::damping), in all directions alike.
    fn dampers(&self, _scene: &ForceContext, _damper: &mut dyn FnMut(Damper)) {}

    /// Times at which its value or slope jumps, s.
    fn corners(&self) -> &[f64] {
        &[]
    }

    /// Why its evaluations have failed, once they have; the run then ends with outcome `error`.
    fn failure(&self) -> Option<ForceError> {
        None
    }
}

/// Stands for an entry that acts in another way than by forces.
pub struct NoForce;

impl Force for NoForce {
    fn evaluate(&mut self, _: &ForceContext, _: &mut AppliedForces) {}
}
