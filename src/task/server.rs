//! Starts, runs and ends the tasks of a scenario.

use super::{Command, Context, Status, Task};

struct Slot {
    start: f64,
    task: Box<dyn Task>,
    begun: bool,
    ended: bool,
}

/// The tasks of one run and the command they have produced.
pub struct TaskServer {
    slots: Vec<Slot>,
    /// What the joints are asked now.
    pub command: Command,
    period: f64,
    tick: u64,
}

impl TaskServer {
    /// A server that ticks `rate` times a second and starts from `command`.
    pub fn new(rate: f64, command: Command) -> Self {
        TaskServer { slots: Vec::new(), command, period: 1.0 / rate, tick: 0 }
    }

    /// Adds a task that begins at the first tick at or after `start` seconds. Later ones win where they overlap.
    pub fn add(&mut self, start: f64, task: Box<dyn Task>) {
        self.slots.push(Slot { start, task, begun: false, ended: false });
    }

    /// Time of the next tick that can change anything; none when all tasks have ended.
    pub fn next_tick(&self) -> Option<f64> {
        let due = |s: &Slot| {
            let earliest = if s.begun { 0 } else { (s.start / self.period - 1e-9).ceil().max(0.0) as u64 };
            earliest.max(self.tick) as f64 * self.period
        };
        self.slots.iter().filter(|s| !s.ended).map(due).min_by(f64::total_cmp)
    }

    /// Runs every task whose time has come; `report(what, name)` hears of each that begins or ends.
    pub fn run(&mut self, context: &Context, mut report: impl FnMut(&str, &str)) {
        self.tick = (context.time / self.period).round() as u64 + 1;
        for slot in self.slots.iter_mut().filter(|s| !s.ended && s.start <= context.time + 1e-9 * self.period) {
            if !slot.begun {
                slot.begun = true;
                report("begins", slot.task.name());
                slot.ended = slot.task.init(context, &self.command) == Status::Done;
            }
            if !slot.ended {
                slot.ended = slot.task.run(context, &mut self.command) == Status::Done;
            }
            if slot.ended {
                report("ends", slot.task.name());
            }
        }
    }
}
