//! Tasks and the task server, which commands the joints at the control rate.
//!
//! As in the paper's section II.B a task has an initialisation, a run and a change function. Tasks
//! of a scenario start and end by time. If several tasks command a joint at once, the last one in
//! the file applies. The joints of an ended task stay at their last positions; [`handover`] treats
//! its other commands. In addition to the state of the robot a task reads [`AugmentedData`], such
//! as Jacobians and the centre of mass. The server computes each part only in ticks at which the
//! [`Needs`] of a running task include it.
//!
//! Imports: `math`, `linalg`, `geometry`, `robot`, `dynamics`, `motion`, `contact`. Used by:
//! `script`, `policy`, `sim`, `assemble`, `remote`, `console`.

pub mod augmented;
pub mod balance;
pub mod blend_in;
pub mod command;
pub mod foresight;
pub mod gait;
pub mod handover;
pub mod kinematic;
pub mod mocap;
pub mod needs;
pub mod playback;
pub mod point_of_interest;
pub mod posture;
pub mod sensor_readings;
pub mod server;
pub mod sine;
pub mod squat;
mod task_error;
mod task_memory;
pub mod walk;

pub use augmented::AugmentedData;
pub use command::Command;
pub use foresight::Foresight;
pub use needs::Needs;
pub use point_of_interest::PointOfInterest;
pub use sensor_readings::SensorReadings;
pub use server::TaskServer;
pub use task_error::{TaskError, TaskFailure};
pub use task_memory::TaskMemory;

use crate::dynamics::State;
use crate::geometry::Plane;
use crate::robot::Model;
use nalgebra::{Isometry3, Translation3, Vector3};
use std::any::Any;

/// The robot and its surroundings as a task reads them.
pub struct Context<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// Start time of the task, s; at its first call after the previous tick and at most this tick.
    pub start: f64,
    /// The robot.
    pub model: &'a Model,
    /// Free fall in world axes, m/s^2.
    pub gravity: Vector3<f64>,
    /// The floor.
    pub floor: Plane,
    /// Base as estimated, joints as sensed.
    pub state: &'a State,
    /// Sensor readings.
    pub sensed: &'a SensorReadings,
    /// Data computed from `state` and `sensed` because a running task needs it.
    pub data: &'a AugmentedData,
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

/// Whether `duration` seconds are over `t` seconds after the start. A tick that misses the end by
/// rounding counts as the end.
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

/// A task, which commands some joints at every control tick.
pub trait Task: Any + Send {
    /// Called once at the task's start. `command` contains the present joint commands.
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult;

    /// Called at every control tick from then on; sets the commands of its joints. Must not
    /// allocate.
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

    /// Whether the modes and efforts it sets apply only while it runs. It must then set them at
    /// every tick.
    fn is_temporary(&self) -> bool {
        false
    }

    /// Whether its commands depend on earlier calls. A run cannot return to an earlier state while
    /// such a task is active, unless it can [`save`](Self::save) what it remembers.
    fn has_memory(&self) -> bool {
        true
    }

    /// What it remembers of earlier calls, for a checkpoint; none if it cannot be copied.
    fn save(&self) -> Option<TaskMemory> {
        None
    }

    /// Returns to what it remembered when it was saved.
    fn restore(&mut self, _saved: &TaskMemory) {}

    /// Called instead of [`run`](Self::run) where an event ends it. Joints whose commands it leaves hold the last ones.
    fn end(&mut self, _context: &Context, _command: &mut Command) {}

    /// How far ahead its commands are known after a call at `now`, s.
    fn foresight(&self, _now: f64) -> Foresight {
        Foresight::NONE
    }

    /// Sets the positions and velocities that [`run`](Self::run) would command at `time`, which is within its
    /// [`foresight`](Self::foresight); at an end or kink of it, the limit from before. Must not allocate.
    fn command_at(&mut self, _time: f64, _command: &mut Command) {}

    /// The augmented data it reads; queried before `init` and before every `run`.
    fn needs(&self) -> Needs {
        Needs::NONE
    }

    /// The points it shows: always the same points in the same order. Positions may change at every
    /// call.
    fn points(&self) -> &[PointOfInterest] {
        &[]
    }

    /// Name in messages.
    fn name(&self) -> &str;
}

/// Downcasts a task to a type.
pub fn of_type<T: Task>(task: Box<dyn Task>) -> Option<Box<T>> {
    (task as Box<dyn Any>).downcast().ok()
}
