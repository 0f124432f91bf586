//! The task server: what the joints are asked to do, decided at the control rate.
//!
//! As in the paper's section II.B a task has an initialisation, a run and a change function. Tasks of a scenario start and
//! end by time; where several drive the same joint at once, the one later in the file wins. A task that has ended leaves
//! its joints where it last put them; what else is left of it, and what an earlier one does then, say [`handover`].
//!
//! Besides the state of the robot a task is given [`Augmented`] data: Jacobians, the centre of mass and so on. Each part
//! is computed only in ticks at which a task asks for it by its [`Needs`].

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

/// What a task sees of the robot when it runs.
pub struct Context<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// When the task was to start, s: at this tick or since the one before the first it is called at.
    pub start: f64,
    /// The robot.
    pub model: &'a Model,
    /// Free fall in world axes, m/s^2.
    pub gravity: Vector3<f64>,
    /// The floor.
    pub floor: Plane,
    /// Base and joints as the estimator and the sensors have them.
    pub state: &'a State,
    /// What the sensors say.
    pub sensed: &'a Sensed,
    /// What was computed from `state` and `sensed` because this task or another one active needs it.
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

/// Is something that lasts `duration` seconds over `t` seconds after its start? A tick whose time is the end's but for rounding
/// is the end.
pub fn has_elapsed(t: f64, duration: f64) -> bool {
    t >= duration - 1e-9
}

/// Does a task go on?
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    /// Call it again at the next tick.
    Running,
    /// It has completed.
    Done,
}

/// Result of a call of a task; an error ends the run with outcome `error`.
pub type TaskResult = Result<Status, TaskError>;

/// One task.
pub trait Task: Any + Send {
    /// Called once when its time comes. `command` is what the joints are asked now.
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult;

    /// Called at every control tick from then on; changes the joints it drives. Allocates nothing.
    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult;

    /// Called once at the first tick at or after each of [`changes`](Self::changes), before `run`: the parameters with
    /// that number come into force.
    fn change(&mut self, _context: &Context, _number: usize) -> TaskResult {
        Ok(Status::Running)
    }

    /// Times at which parameters change, ascending, s.
    fn changes(&self) -> &[f64] {
        &[]
    }

    /// Takes over the changes of `newer`, which was made from the same entry with changes added at its end. Those that were
    /// made already stay as they are.
    fn adopt_changes(&mut self, _newer: Box<dyn Task>) {}

    /// Do the modes and efforts it sets hold only as long as it lasts? It then sets them at every tick.
    fn is_temporary(&self) -> bool {
        false
    }

    /// The augmented data it reads. Asked anew before `init` and before every `run`.
    fn needs(&self) -> Needs {
        Needs::NONE
    }

    /// The points it shows, always the same ones in the same order; where they are may change with every call.
    fn points(&self) -> &[PointOfInterest] {
        &[]
    }

    /// For messages.
    fn name(&self) -> &str;
}

/// A task of a certain type, if it is one.
pub(crate) fn of_type<T: Task>(task: Box<dyn Task>) -> Option<Box<T>> {
    (task as Box<dyn Any>).downcast().ok()
}
