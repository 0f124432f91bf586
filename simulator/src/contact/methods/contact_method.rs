//! Interface of contact methods: [`ContactMethod`] is a method with its parameters,
//! [`ContactSolver`] solves the problems of one run with it.
//!
//! The methods of this crate are listed in [`super::registry`]. A method outside the crate
//! implements both traits and is set as `Setup::contact.method`.

use super::registry::MethodParameters;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::States;
use crate::contact::search::select::Selection;
use nalgebra::{Matrix3, Vector3};
use std::fmt::Debug;

pub use crate::contact::search::select::SelectionInput;

/// A contact method with its parameters, shared by runs.
pub trait ContactMethod: Debug + Send + Sync {
    /// Name in logs, summaries and messages.
    fn name(&self) -> &str;

    /// A solver for problems with the soles and vertices of `p`. Allocates all its memory here.
    fn solver(&self, p: &Problem) -> Box<dyn ContactSolver>;

    /// Parameters that records of selections store with the name.
    fn parameters(&self) -> MethodParameters {
        MethodParameters::default()
    }
}

/// How a method advances in time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Scheme {
    /// Searches for valid states: events are located, impacts are separate problems, and a step
    /// closes its gaps.
    EventDriven,
    /// Decides from the quantities at the start of each step, and holds the decision for the step.
    DecidedPerStep,
    /// Forces follow from present positions and velocities: nothing is clamped, no velocity jumps,
    /// states are labels.
    Compliant,
    /// Solves for the velocities at the end of a fixed step and the impulses over it. It has no
    /// forces within a step, selects no states beforehand, and gives the load of each vertex.
    TimeStepping,
}

/// Energy that a compliant method stores in its springs.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct StoredEnergy {
    /// The energy, J.
    pub energy: f64,
    /// Its rate with the present velocities, W.
    pub power: f64,
}

/// How the force on a vertex of a compliant method changes with its height h, m, and velocity u, m/s, and the power of
/// the springs with both. Contact axes.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct VertexSlopes {
    /// df/dh, N/m.
    pub by_height: Vector3<f64>,
    /// df/du, N s/m.
    pub by_velocity: Matrix3<f64>,
    /// Change of the power of the springs with h, W/m, and with the velocity along the normal, N.
    pub power: [f64; 2],
}

/// Solves the contact problems of one run: selects states and computes wrenches. No call allocates.
pub trait ContactSolver: Send {
    /// How it advances in time.
    fn scheme(&self) -> Scheme;

    /// Are its events located, or does it only act at the start of each step?
    fn locates_events(&self) -> bool {
        self.scheme() == Scheme::EventDriven
    }

    /// Do its solutions contain vertex forces? Otherwise the wrenches of static soles are
    /// distributed over their vertices.
    fn gives_vertex_forces(&self) -> bool {
        matches!(self.scheme(), Scheme::Compliant | Scheme::TimeStepping)
    }

    /// Selects the states at the acceleration level and leaves their wrenches in `out`. On entry
    /// `out` contains the last known solution.
    fn select(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection;

    /// Selects states and impulses at the velocity level: an impact, or a step of a time-stepping
    /// integrator. Leaves the wrenches and the impulses of all vertices in `out`.
    fn impulse(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection;

    /// Impulses of a velocity-level step with every vertex as a point, and the states that they
    /// indicate. None if the method has no such solution, or not to its accuracy.
    fn point_impulse(&mut self, _: &Problem, _: &mut Solution) -> Option<States> {
        None
    }

    /// Wrenches for fixed states, with the directions in the problem: called at every evaluation.
    fn respond(&mut self, p: &Problem, states: &States, out: &mut Solution);

    /// Energy of the method's springs at the present positions of the vertices.
    fn stored(&self, _: &Problem) -> StoredEnergy {
        StoredEnergy::default()
    }

    /// A copy with its memory, for checkpoints; none if it cannot be copied. Methods without memory between
    /// calls need no copy.
    fn copy(&self) -> Option<Box<dyn ContactSolver>> {
        None
    }

    /// Calls `each` with sole, vertex and slopes of every vertex whose force follows from its present height and
    /// velocity.
    fn slopes(&self, _: &Problem, _each: &mut dyn FnMut(usize, usize, VertexSlopes)) {}
}
