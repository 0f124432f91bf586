//! The task server: what the joints are asked to do, decided at the control rate.
//!
//! As in the paper's section II.B a task has an initialisation and a run function. Tasks of a scenario start and end by
//! time; where several drive the same joint at once, the one later in the file wins. A task that has ended leaves its
//! joints where it last put them.

pub mod posture;
pub mod server;

pub use server::TaskServer;

use crate::robot::Model;

/// What a task sees of the robot when it runs.
pub struct Context<'a> {
    /// Simulated time, s.
    pub time: f64,
    /// The robot.
    pub model: &'a Model,
    /// Joint positions, rad or m.
    pub q: &'a [f64],
    /// Joint velocities.
    pub qd: &'a [f64],
}

/// What the joints are asked to do: one entry per joint, held until the next control tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// Desired positions, rad or m.
    pub position: Vec<f64>,
    /// Desired velocities.
    pub velocity: Vec<f64>,
    /// Feed-forward efforts, N m or N.
    pub effort: Vec<f64>,
}

impl Command {
    /// Hold this posture.
    pub fn hold(position: &[f64]) -> Self {
        Command { position: position.to_vec(), velocity: vec![0.0; position.len()], effort: vec![0.0; position.len()] }
    }
}

/// Does a task go on?
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    /// Call it again at the next tick.
    Running,
    /// It has completed.
    Done,
}

/// One task.
pub trait Task: Send {
    /// Called once when its time comes. `command` is what the joints are asked now.
    fn init(&mut self, context: &Context, command: &Command) -> Status;
    /// Called at every control tick from then on; changes the joints it drives.
    fn run(&mut self, context: &Context, command: &mut Command) -> Status;
    /// For messages.
    fn name(&self) -> &str;
}
