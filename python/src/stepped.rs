//! A run that its caller advances: commands, events and log, and how far it is.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use stiction::log::LogWriter;
use stiction::robot::DriveMode;
use stiction::sim::{Observer, ObserverError, Outcome, RunError, SimEvent, Simulation as Run, Snapshot};
use stiction::{Command, Context, Status, Task, TaskResult};

/// Time between checks for signals, such as that of Ctrl-C.
pub const PATIENCE: Duration = Duration::from_millis(50);

/// Joint commands of the caller, which hold until the next ones; none for values left to the tasks.
#[derive(Clone, Default)]
pub struct Commanded {
    pub position: Option<Vec<f64>>,
    pub velocity: Option<Vec<f64>>,
    pub effort: Option<Vec<f64>>,
    pub kp: Option<Vec<f64>>,
    pub kd: Option<Vec<f64>>,
    pub mode: Option<Vec<DriveMode>>,
}

/// The last task of a run: applies the commands of the caller.
struct CommandTask(Arc<Mutex<Commanded>>);

impl Task for CommandTask {
    fn init(&mut self, _: &Context, _: &Command) -> TaskResult {
        Ok(Status::Running)
    }

    fn run(&mut self, _: &Context, command: &mut Command) -> TaskResult {
        let given = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let pairs = [
            (&given.position, &mut command.position),
            (&given.velocity, &mut command.velocity),
            (&given.effort, &mut command.effort),
            (&given.kp, &mut command.kp),
            (&given.kd, &mut command.kd),
        ];
        for (from, to) in pairs {
            from.iter().for_each(|from| to.copy_from_slice(from));
        }
        given.mode.iter().for_each(|mode| command.mode.copy_from_slice(mode));
        Ok(Status::Running)
    }

    fn has_memory(&self) -> bool {
        false
    }

    fn name(&self) -> &str {
        "command"
    }
}

/// Keeps the events and writes the log.
#[derive(Default)]
pub struct Recorder {
    pub log: Option<LogWriter>,
    pub events: Vec<SimEvent>,
}

impl Observer for Recorder {
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), ObserverError> {
        self.log.as_mut().map_or(Ok(()), |log| log.snapshot(snapshot))
    }

    fn event(&mut self, event: &SimEvent) -> Result<(), ObserverError> {
        self.events.push(event.clone());
        self.log.as_mut().map_or(Ok(()), |log| log.event(event))
    }
}

/// A run, and how far it is.
pub struct Stepped {
    pub run: Run,
    pub recorder: Recorder,
    pub commanded: Arc<Mutex<Commanded>>,
    /// Whether the run has control ticks at which the caller may command joints.
    pub ticks: bool,
    pub rate: f64,
    pub end: Option<(Outcome, String)>,
    pub cancel: Arc<AtomicBool>,
}

impl Stepped {
    /// Adds the task that applies the caller's commands, once: from now on every control tick ends a step.
    pub fn tick_always(&mut self) {
        if !self.ticks {
            self.ticks = true;
            self.run.add_task(0.0, Box::new(CommandTask(self.commanded.clone())));
        }
    }

    /// Advances by control ticks, until one at which `interrupted`, called from time to time, is true. Returns
    /// whether the run continues.
    pub fn step(&mut self, ticks: u64, mut interrupted: impl FnMut() -> bool) -> Result<bool, RunError> {
        self.tick_always();
        let now = (self.run.time() * self.rate + 1e-9).floor();
        let (mut checked, mut continues) = ((ticks > 1).then(Instant::now), self.end.is_none());
        for tick in 1..=ticks.max(1) {
            continues = self.advance((now + tick.min(ticks) as f64) / self.rate)?;
            if let Some(last) = checked
                && last.elapsed() > PATIENCE
            {
                if interrupted() {
                    break;
                }
                checked = Some(Instant::now());
            }
            if !continues {
                break;
            }
        }
        Ok(continues)
    }

    /// Advances to the first end of a step at or after `time`, s. Returns whether the run continues.
    pub fn advance(&mut self, time: f64) -> Result<bool, RunError> {
        self.check()?;
        if self.end.is_some() {
            return Ok(false);
        }
        let done = self.run.advance_to(time, &mut self.recorder);
        done.map_err(|error| self.failed(error))?;
        if self.run.time() < self.run.end() {
            return Ok(true);
        }
        self.finish().map(|()| false)
    }

    /// An error if the run has ended early.
    fn check(&self) -> Result<(), RunError> {
        match &self.end {
            Some((Outcome::Passed, _)) | None => Ok(()),
            Some((outcome, message)) => Err(RunError::new(*outcome, message.as_str())),
        }
    }

    fn failed(&mut self, error: RunError) -> RunError {
        self.end = Some((error.outcome, error.message.clone()));
        // The log of a run that ended early is complete up to there.
        let _ = self.recorder.log.take().map(LogWriter::finish);
        error
    }

    /// Runs to the end and completes metrics and log.
    pub fn finish(&mut self) -> Result<(), RunError> {
        if self.end.is_some() {
            return self.check();
        }
        let (outcome, message) = self.run.run(&mut self.recorder, &self.cancel);
        if outcome != Outcome::Passed {
            return Err(self.failed(RunError::new(outcome, message)));
        }
        self.end = Some((outcome, message));
        let written = self.recorder.log.take().map_or(Ok(()), LogWriter::finish);
        written.map_err(|error| self.failed(RunError::internal(error)))
    }
}
