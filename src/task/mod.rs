//! Tasks and the task server, which commands the joints at the control rate.
//!
//! As in the paper's section II.B a task has an initialisation, a run and a change function. Tasks
//! of a scenario start and end by time; where several drive a joint at once, the later one in the
//! file wins. A task that has ended leaves its joints at their last positions; [`handover`] treats
//! everything else it has set. Besides the state of the robot a task reads [`Augmented`] data such
//! as Jacobians and the centre of mass. The server computes each part only in ticks at which the
//! [`Needs`] of a running task include it.
//!
//! Imports robot, dynamics, geometry, motion, linalg and contact (load sharing). Called by script,
//! sim, remote and assemble.

pub mod augmented;
pub mod balance;
pub mod blend_in;
pub mod command;
mod error;
pub mod gait;
pub mod handover;
pub mod kinematic;
pub mod mocap;
pub mod needs;
pub mod playback;
pub mod point_of_interest;
pub mod posture;
pub mod sensed;
pub mod server;
pub mod sine;
pub mod squat;
pub mod walk;

pub use augmented::Augmented;
pub use command::Command;
pub use error::{TaskError, TaskFailure};
pub use needs::Needs;
pub use point_of_interest::PointOfInterest;
pub use sensed::Sensed;
pub use server::TaskServer;

use crate::dynamics::State;
use crate::geometry::Plane;
use crate::robot::Model;
use nalgebra::{Isometry3, Translation3, Vector3};
use std::any::Any;

/// The robot and its surroundings as a task reads them.
pub struct Context<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// Start time of the task, s: this tick or, at the first call, after the tick before.
    pub start: f64,
    /// The robot.
    pub model: &'a Model,
    /// Free fall in world axes, m/s^2.
    pub gravity: Vector3<f64>,
    /// The floor.
    pub floor: Plane,
    /// Base and joints as the estimator and the sensors have them.
    pub state: &'a State,
    /// Sensor readings.
    pub sensed: &'a Sensed,
    /// Data computed from `state` and `sensed` because a running task needs it.
    pub data: &'a Augmented,
}

impl Context<'_> {
    /// Pose of the root link's frame in the world.
    pub fn base(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.state.position), self.state.rotation)
    }

    /// Joint positions, rad or m.
    pub fn q(&self) -> &[f64] {
        &self.state.joints
    }

    /// Joint velocities.
    pub fn qd(&self) -> &[f64] {
        &self.state.v[self.model.nb()..]
    }
}

/// True when a duration of `duration` seconds is over `t` seconds after its start. A tick that
/// misses the end by rounding counts as the end.
pub fn has_elapsed(t: f64, duration: f64) -> bool {
    t >= duration - 1e-9
}

/// Whether a task continues.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    /// Call it again at the next tick.
    Running,
    /// It has completed.
    Done,
}

/// Result of a call of a task; an error ends the run with outcome `error`.
pub type TaskResult = Result<Status, TaskError>;

/// A task: commands some joints at every control tick.
pub trait Task: Any + Send {
    /// Called once at the task's start. `command` holds the present joint commands.
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult;

    /// Called at every control tick from then on; changes the commands of its joints. Allocates
    /// nothing.
    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult;

    /// Called once at the first tick at or after each of [`changes`](Self::changes), before `run`:
    /// applies the parameters with that number.
    fn change(&mut self, _context: &Context, _number: usize) -> TaskResult {
        Ok(Status::Running)
    }

    /// Times at which parameters change, ascending, s.
    fn changes(&self) -> &[f64] {
        &[]
    }

    /// Adopts the changes of `newer`, built from the same entry with changes appended. Changes
    /// already applied keep their effect.
    fn adopt_changes(&mut self, _newer: Box<dyn Task>) {}

    /// True if the modes and efforts it sets hold only while it lasts. It must then set them at
    /// every tick.
    fn is_temporary(&self) -> bool {
        false
    }

    /// The augmented data it reads; queried before `init` and before every `run`.
    fn needs(&self) -> Needs {
        Needs::NONE
    }

    /// The points it shows: always the same ones in the same order, with positions that may change
    /// at every call.
    fn points(&self) -> &[PointOfInterest] {
        &[]
    }

    /// Name in messages.
    fn name(&self) -> &str;
}

/// Downcasts a task to a type.
pub(crate) fn of_type<T: Task>(task: Box<dyn Task>) -> Option<Box<T>> {
    (task as Box<dyn Any>).downcast().ok()
}
