//! `policy`: commands joints by a network.
//!
//! ```text
//! q = q0 + s a,   a = max(-c, min(c, network(observations)))
//! ```
//!
//! with the desired position (or the effort, for which q0 = 0) q, default posture q0, scale s and
//! greatest magnitude c. The network is evaluated at every n-th control tick.

use super::observation::{Observed, Term};
use super::{History, Network};
use crate::robot::DriveMode;
use crate::task::{Command, Context, Needs, Status, Task, TaskError, TaskMemory, TaskResult, has_elapsed, of_type};

/// Quantity that a policy commands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ActionMode {
    /// Joint positions.
    Position,
    /// Joint efforts.
    Force,
}

/// Use of a network's output. Lists have an entry for each number of the output.
#[derive(Clone, Debug)]
pub struct Action {
    /// Indices of the joints.
    pub joints: Vec<usize>,
    /// What is commanded.
    pub mode: ActionMode,
    /// Whether the joint's drive is set to follow `mode`; not that of passive and kinematic joints.
    pub driven: Vec<bool>,
    /// Factors, rad, m, N m or N.
    pub scale: Vec<f64>,
    /// Default positions, rad or m, or zeros for efforts.
    pub offset: Vec<f64>,
    /// Greatest magnitude of the output.
    pub clip: f32,
    /// Position gains of the drives; none: those of the robot.
    pub kp: Option<Vec<f64>>,
    /// Velocity gains of the drives; none: those of the robot.
    pub kd: Option<Vec<f64>>,
}

/// Settings of a policy.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Terms of an observation.
    pub terms: Vec<Term>,
    /// The last observations.
    pub history: History,
    /// Use of the output.
    pub action: Action,
    /// Control ticks per evaluation, at least 1.
    pub decimation: u32,
    /// The given numbers of the term `command`.
    pub command: Vec<f64>,
    /// New given numbers at times, s, ascending.
    pub changes: Vec<(f64, Vec<f64>)>,
    /// Simulated time at which it ends, s.
    pub end: f64,
}

/// What a policy remembers from tick to tick.
#[derive(Clone, Debug)]
struct Memory {
    history: History,
    /// Limited output of the last evaluation.
    action: Vec<f32>,
    /// States of a recurrent network.
    state: Vec<Vec<f32>>,
    /// Calls so far.
    calls: u64,
    command: Vec<f64>,
}

/// Task that commands joints by a network.
pub struct Policy {
    terms: Vec<Term>,
    action: Action,
    decimation: u64,
    /// Times of changes, s, and the given numbers from then on.
    changes: Vec<f64>,
    commands: Vec<Vec<f64>>,
    end: f64,
    network: Box<dyn Network>,
    memory: Memory,
    /// The present observation.
    observation: Vec<f32>,
    /// All observations that the network receives.
    input: Vec<f32>,
}

/// A number that is not finite in the output of a network.
#[derive(Debug, thiserror::Error)]
#[error("the network's output for joint `{joint}` is {value} at {time} s")]
struct NotFinite {
    joint: String,
    value: f32,
    time: f64,
}

impl Policy {
    /// A task with these settings and their network.
    pub fn new(settings: Settings, network: Box<dyn Network>) -> Self {
        let width: usize = settings.terms.iter().map(|term| term.quantity.width()).sum();
        let (changes, commands) = settings.changes.into_iter().unzip();
        Policy {
            decimation: u64::from(settings.decimation),
            changes,
            commands,
            end: settings.end,
            memory: Memory {
                action: vec![0.0; settings.action.joints.len()],
                state: network.state_sizes().iter().map(|size| vec![0.0; *size]).collect(),
                calls: 0,
                command: settings.command,
                history: settings.history.clone(),
            },
            observation: vec![0.0; width],
            input: vec![0.0; settings.history.width()],
            terms: settings.terms,
            action: settings.action,
            network,
        }
    }

    fn evaluate(&mut self, context: &Context) -> Result<(), TaskError> {
        let memory = &mut self.memory;
        let since = context.time - context.start;
        let now = Observed { context, since, command: &memory.command, previous: &memory.action };
        let mut rest = &mut self.observation[..];
        for term in &self.terms {
            let (own, others) = rest.split_at_mut(term.quantity.width());
            term.write(&now, own);
            rest = others;
        }
        memory.history.push(&self.observation, &mut self.input);
        let evaluated = self.network.evaluate(&self.input, &mut memory.state, &mut memory.action);
        evaluated.map_err(TaskError::Other)?;
        for (a, joint) in memory.action.iter_mut().zip(&self.action.joints) {
            if !a.is_finite() {
                let joint = context.model.joints[*joint].name.clone();
                return Err(TaskError::other(NotFinite { joint, value: *a, time: context.time }));
            }
            *a = a.clamp(-self.action.clip, self.action.clip);
        }
        Ok(())
    }
}

impl Action {
    /// Sets the commands of its joints.
    fn apply(&self, output: &[f32], command: &mut Command) {
        for (i, &j) in self.joints.iter().enumerate() {
            let value = self.offset[i] + self.scale[i] * f64::from(output[i]);
            let mode = match self.mode {
                ActionMode::Position => {
                    (command.position[j], command.velocity[j]) = (value, 0.0);
                    DriveMode::Position
                }
                ActionMode::Force => {
                    command.effort[j] = value;
                    DriveMode::Force
                }
            };
            if self.driven[i] {
                command.mode[j] = mode;
            }
            if let Some(kp) = &self.kp {
                command.kp[j] = kp[i];
            }
            if let Some(kd) = &self.kd {
                command.kd[j] = kd[i];
            }
        }
    }
}

impl Task for Policy {
    fn init(&mut self, _: &Context, _: &Command) -> TaskResult {
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        if has_elapsed(context.time, self.end) {
            return Ok(Status::Done);
        }
        if self.memory.calls.is_multiple_of(self.decimation) {
            self.evaluate(context)?;
        }
        self.memory.calls += 1;
        self.action.apply(&self.memory.action, command);
        Ok(Status::Running)
    }

    fn change(&mut self, _: &Context, number: usize) -> TaskResult {
        self.memory.command.copy_from_slice(&self.commands[number]);
        Ok(Status::Running)
    }

    fn changes(&self) -> &[f64] {
        &self.changes
    }

    fn adopt_changes(&mut self, newer: Box<dyn Task>) {
        if let Some(newer) = of_type::<Self>(newer) {
            (self.changes, self.commands) = (newer.changes, newer.commands);
        }
    }

    fn is_temporary(&self) -> bool {
        true
    }

    fn save(&self) -> Option<TaskMemory> {
        Some(TaskMemory::new(self.memory.clone()))
    }

    fn restore(&mut self, saved: &TaskMemory) {
        if let Some(memory) = saved.get::<Memory>() {
            self.memory = memory.clone();
        }
    }

    fn needs(&self) -> Needs {
        self.terms.iter().fold(Needs::NONE, |needs, term| needs | term.quantity.needs())
    }

    fn name(&self) -> &str {
        "policy"
    }
}
