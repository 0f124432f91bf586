//! The task server: starts, runs, changes and ends the tasks of a scenario.

use super::handover::{Handover, LastCommand, TemporaryEfforts};
use super::{
    AugmentedData, Command, Context, Foresight, Needs, SensorReadings, Status, Task, TaskError, TaskFailure, TaskMemory,
};
use crate::dynamics::State;
use crate::geometry::Plane;
use crate::robot::Model;
use nalgebra::Vector3;

struct TaskSlot {
    start: f64,
    task: Box<dyn Task>,
    begun: bool,
    ended: bool,
    /// Whether it ends at the next tick regardless of its result.
    end_requested: bool,
    /// Number of parameter changes applied so far.
    changed: usize,
    temporary: TemporaryEfforts,
    last: LastCommand,
}

/// The tasks of one run and the command they produce.
pub struct TaskServer {
    slots: Vec<TaskSlot>,
    /// Present joint commands.
    pub command: Command,
    handover: Handover,
    augmented: AugmentedData,
    rate: f64,
    tick: u64,
    /// Number after that of the last tick: `tick`, unless ticks are left out.
    following: u64,
    /// Whether it ticks even without active tasks.
    always: bool,
    /// Number of the next tick as set by a remote task server; inner none: no further tick.
    remote_next: Option<Option<u64>>,
}

/// State of a task.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TaskState {
    /// Before its start time.
    Waiting,
    /// Called at every tick.
    Running,
    /// Ended.
    Ended,
}

/// The robot at a tick.
pub struct TickInput<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Free fall in world axes, m/s^2.
    pub gravity: Vector3<f64>,
    /// The floor.
    pub floor: Plane,
    /// Base as estimated, joints as sensed; its time is the tick's.
    pub state: &'a State,
    /// Sensor readings.
    pub sensed: &'a SensorReadings,
}

impl TaskServer {
    /// A server that ticks `rate` times a second and starts from `command`.
    pub fn new(rate: f64, model: &Model, command: Command) -> Self {
        TaskServer {
            slots: Vec::new(),
            handover: Handover::new(&command),
            command,
            augmented: AugmentedData::new(model),
            rate,
            tick: 0,
            following: 0,
            always: false,
            remote_next: None,
        }
    }

    /// Makes it tick even without active tasks, so that sensors are read.
    pub fn tick_always(&mut self) {
        self.always = true;
    }

    /// Counts the tick at `time` as run by a remote task server. `next` is its next tick; without
    /// one the command stays to the end. Tasks of this server are not called.
    pub fn set_remote_tick(&mut self, time: f64, next: Option<u64>) {
        self.count_tick(time);
        self.remote_next = Some(next.map(|next| next.max(self.tick)));
    }

    /// Number of the next tick, see [`next_tick`](Self::next_tick).
    pub fn next_number(&self) -> Option<u64> {
        self.next_tick().map(|time| (time * self.rate).round() as u64)
    }

    /// Time between ticks, s.
    pub fn period(&self) -> f64 {
        1.0 / self.rate
    }

    /// Adds a task that begins at the first tick at or after `start` seconds, its time 0. Commands
    /// of later tasks override those of earlier ones.
    pub fn add(&mut self, start: f64, task: Box<dyn Task>) {
        let temporary = TemporaryEfforts::new(self.command.mode.len());
        self.slots.push(TaskSlot {
            start,
            task,
            begun: false,
            ended: false,
            end_requested: false,
            changed: 0,
            temporary,
            last: LastCommand::new(self.command.mode.len()),
        });
    }

    /// Ends task `number`, in the order in which they were added, at the next tick. A task that has
    /// not begun never begins.
    pub fn end(&mut self, number: usize) {
        if let Some(slot) = self.slots.get_mut(number) {
            slot.end_requested = true;
            slot.ended |= !slot.begun;
        }
    }

    /// Extends this server to the tasks of `newer`: a scenario with tasks appended, and changes
    /// appended to the tasks it had.
    pub fn extend_with(&mut self, newer: TaskServer) {
        for (i, slot) in newer.slots.into_iter().enumerate() {
            match self.slots.get_mut(i) {
                Some(present) => present.task.adopt_changes(slot.task),
                None => self.slots.push(slot),
            }
        }
    }

    /// Name, start and state of each task.
    pub fn states(&self) -> impl Iterator<Item = (&str, f64, TaskState)> {
        self.slots.iter().map(|slot| {
            let state = match (slot.begun, slot.ended) {
                (_, true) => TaskState::Ended,
                (true, false) => TaskState::Running,
                (false, false) => TaskState::Waiting,
            };
            (slot.task.name(), slot.start, state)
        })
    }

    /// Time of the next tick that can change the command; none when all tasks have ended. Tick k is
    /// at `k / rate`, equal to the last bit to the log's instants and other clocks that divide
    /// integers by their rates.
    pub fn next_tick(&self) -> Option<f64> {
        if let Some(next) = self.remote_next {
            return next.map(|next| next as f64 / self.rate);
        }
        if self.always {
            return Some(self.tick as f64 / self.rate);
        }
        let due = |s: &TaskSlot| {
            let earliest = if s.begun { 0 } else { (s.start * self.rate - 1e-9).ceil().max(0.0) as u64 };
            earliest.max(self.tick) as f64 / self.rate
        };
        let next = self.tick as f64 / self.rate;
        let decays = (next < self.handover.until() + self.period()).then_some(next);
        self.slots.iter().filter(|s| !s.ended).map(due).chain(decays).min_by(f64::total_cmp)
    }

    fn count_tick(&mut self, time: f64) {
        self.tick = (time * self.rate).round() as u64 + 1;
        self.following = self.tick;
    }

    /// Sets the command to that of the tick before the one at `time`, if ticks were left out.
    fn catch_up(&mut self, time: f64) {
        let number = (time * self.rate).round() as u64;
        if number > self.following {
            let last = (number - 1) as f64 / self.rate;
            for slot in self.slots.iter_mut().filter(|s| s.is_running()) {
                self.handover.before(&self.command);
                slot.task.command_at(last, &mut self.command);
                self.handover.note(&mut slot.last, false, &self.command);
            }
        }
    }

    /// How far ahead commands are known after the tick at `now`. Commands of joints that an ended task has
    /// released are not.
    pub(crate) fn foresight(&self, now: f64) -> Foresight {
        let decays = now < self.handover.until() + self.period();
        if self.always || self.remote_next.is_some() || decays || !self.slots.iter().any(TaskSlot::is_running) {
            return Foresight::NONE;
        }
        let known = |slot: &TaskSlot| match (slot.is_running(), slot.ended) {
            (_, true) => Foresight::UNLIMITED,
            (true, _) if slot.end_requested => Foresight::NONE,
            (true, _) => {
                let change = slot.task.changes().get(slot.changed).copied().unwrap_or(f64::INFINITY);
                slot.task.foresight(now).within(change)
            }
            (false, _) => Foresight::UNLIMITED.within(slot.start),
        };
        self.slots.iter().map(known).fold(Foresight::UNLIMITED, Foresight::and)
    }

    /// Sets the positions and velocities at `time`, which is within the [`foresight`](Self::foresight); `command`
    /// contains those of the last tick.
    pub(crate) fn command_at(&mut self, time: f64, command: &mut Command) {
        self.slots.iter_mut().filter(|s| s.is_running()).for_each(|slot| slot.task.command_at(time, command));
    }

    /// Number of ticks after the last one until `time`, s.
    pub(crate) fn ticks_until(&self, time: f64) -> u64 {
        let last = (time * self.rate + 1e-9).floor().max(0.0) as u64;
        last.saturating_add(1).saturating_sub(self.following)
    }

    /// Time of the tick that is number `ticks` after the last one, s.
    pub(crate) fn time_after(&self, ticks: u64) -> f64 {
        (self.following - 1 + ticks) as f64 / self.rate
    }

    /// Leaves out the next `ticks` ticks, whose commands are known.
    pub(crate) fn skip_ticks(&mut self, ticks: u64) {
        self.tick = self.following + ticks;
    }

    /// Leaves out no tick after `time` any more, because commands may change otherwise than foreseen.
    pub(crate) fn resume_ticks(&mut self, time: f64) {
        let due = (time * self.rate - 1e-9).ceil().max(0.0) as u64;
        self.tick = self.tick.min(due.max(self.following));
    }

    /// Parts of the augmented data that the tasks read at a tick at `time`.
    pub fn needs(&self, time: f64) -> Needs {
        let soon = time + 1e-9 / self.rate;
        let active = self.slots.iter().filter(|s| !s.ended && s.start <= soon);
        active.fold(Needs::NONE, |needs, s| needs | s.task.needs())
    }

    /// The points of the tasks, in the order of the tasks. Points of tasks that do not run have no
    /// position.
    pub fn points(&self) -> impl Iterator<Item = (&str, Option<Vector3<f64>>)> {
        self.slots.iter().flat_map(|slot| {
            let runs = slot.begun && !slot.ended;
            slot.task.points().iter().map(move |point| (point.name.as_str(), point.position.filter(|_| runs)))
        })
    }

    /// Runs every task that is due. Calls `report(change, name)` for each that begins, changes or
    /// ends.
    ///
    /// # Errors
    /// The error of the first task that failed.
    pub fn run(&mut self, now: &TickInput, mut report: impl FnMut(&str, &str)) -> Result<(), TaskFailure> {
        let time = now.state.time;
        self.catch_up(time);
        self.count_tick(time);
        let soon = time + 1e-9 / self.rate;
        let active = |s: &TaskSlot| !s.ended && s.start <= soon;
        let needs = self.needs(time);
        self.augmented.update(now.model, now.state, now.sensed, &now.gravity, &now.floor, needs);
        let mut context = Context {
            time,
            start: time,
            model: now.model,
            gravity: now.gravity,
            floor: now.floor,
            state: now.state,
            sensed: now.sensed,
            data: &self.augmented,
        };
        self.handover.begin(time, &mut self.command);
        for slot in self.slots.iter_mut().filter(|s| active(s)) {
            context.start = slot.start;
            self.handover.before(&self.command);
            let ended = slot.call(&context, &mut self.command, soon, &mut report);
            slot.ended = ended.map_err(|error| TaskFailure { task: slot.task.name().to_owned(), error })?;
            let temporary = slot.task.is_temporary().then_some(&mut slot.temporary);
            self.handover.after(temporary, &mut slot.last, slot.ended, time, &mut self.command);
            if slot.ended {
                report("ends", slot.task.name());
            }
        }
        self.handover.end(time, &mut self.command);
        Ok(())
    }
}

/// Progress of the tasks of a server: commands, ticks, and which tasks have begun and ended.
#[derive(Clone)]
pub struct TaskProgress {
    command: Command,
    handover: Handover,
    tick: u64,
    following: u64,
    remote_next: Option<Option<u64>>,
    slots: Vec<SlotProgress>,
}

#[derive(Clone)]
struct SlotProgress {
    memory: Option<TaskMemory>,
    begun: bool,
    ended: bool,
    end_requested: bool,
    changed: usize,
    temporary: TemporaryEfforts,
    last: LastCommand,
}

impl TaskServer {
    /// The present progress.
    pub fn progress(&self) -> TaskProgress {
        TaskProgress {
            command: self.command.clone(),
            handover: self.handover.clone(),
            tick: self.tick,
            following: self.following,
            remote_next: self.remote_next,
            slots: self.slots.iter().map(TaskSlot::progress).collect(),
        }
    }

    /// Returns to an earlier progress of these tasks.
    ///
    /// # Errors
    /// The name of a task with memory that was called since, or would continue from there.
    pub fn return_to(&mut self, progress: &TaskProgress) -> Result<(), String> {
        let kept = |slot: &TaskSlot, then: &SlotProgress| {
            let forgets = !slot.task.has_memory() || then.memory.is_some();
            forgets || (!slot.begun && !then.begun) || (slot.ended && then.ended)
        };
        if let Some((slot, _)) = self.slots.iter().zip(&progress.slots).find(|(slot, then)| !kept(slot, then)) {
            return Err(slot.task.name().to_owned());
        }
        self.command.copy_from(&progress.command);
        self.handover = progress.handover.clone();
        (self.tick, self.following, self.remote_next) = (progress.tick, progress.following, progress.remote_next);
        for (slot, then) in self.slots.iter_mut().zip(&progress.slots) {
            (slot.begun, slot.ended, slot.end_requested) = (then.begun, then.ended, then.end_requested);
            (slot.changed, slot.temporary, slot.last) = (then.changed, then.temporary.clone(), then.last.clone());
            if let Some(memory) = &then.memory {
                slot.task.restore(memory);
            }
        }
        Ok(())
    }
}

impl TaskSlot {
    fn is_running(&self) -> bool {
        self.begun && !self.ended
    }

    fn progress(&self) -> SlotProgress {
        SlotProgress {
            memory: self.task.save(),
            begun: self.begun,
            ended: self.ended,
            end_requested: self.end_requested,
            changed: self.changed,
            temporary: self.temporary.clone(),
            last: self.last.clone(),
        }
    }

    /// Makes all calls that are due at a tick. Returns whether the task is done.
    fn call(
        &mut self,
        context: &Context,
        command: &mut Command,
        soon: f64,
        report: &mut impl FnMut(&str, &str),
    ) -> Result<bool, TaskError> {
        if self.end_requested {
            if self.begun {
                self.task.end(context, command);
            }
            return Ok(true);
        }
        if !self.begun {
            self.begun = true;
            report("begins", self.task.name());
            if self.task.init(context, command)? == Status::Done {
                return Ok(true);
            }
        }
        while self.task.changes().get(self.changed).is_some_and(|t| *t <= soon) {
            self.changed += 1;
            report("changes", self.task.name());
            if self.task.change(context, self.changed - 1)? == Status::Done {
                return Ok(true);
            }
        }
        Ok(self.task.run(context, command)? == Status::Done)
    }
}
