//! The one who is told everything: keeps the order, the clock of each run, and the only voice.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use super::cancel::Gate;
use super::event::Event;
use super::{Cancellation, Finished, Options, Plan, Progress, Reason};
use crate::record::{RecordError, RunsLog};

/// A run that has started and not finished.
struct Active {
    cancellation: Arc<Cancellation>,
    /// When its time is up; none: never, or it has been told already.
    deadline: Option<Instant>,
}

/// What was collected.
pub(super) struct Collected {
    /// In the order of the plan.
    pub finished: Vec<Finished>,
    pub interrupted: bool,
}

/// Linearises what happens in a batch.
pub(super) struct Dispatcher<'a> {
    plan: &'a Plan,
    options: &'a Options,
    gate: &'a Gate,
    runs_log: &'a mut RunsLog,
    progress: Progress,
    active: BTreeMap<usize, Active>,
    finished: BTreeMap<usize, Finished>,
    interruptions: u32,
    failure: Option<RecordError>,
}

impl<'a> Dispatcher<'a> {
    pub fn new(
        plan: &'a Plan,
        options: &'a Options,
        gate: &'a Gate,
        runs_log: &'a mut RunsLog,
        progress: Progress,
    ) -> Self {
        let (active, finished) = (BTreeMap::new(), BTreeMap::new());
        Self { plan, options, gate, runs_log, progress, active, finished, interruptions: 0, failure: None }
    }

    /// Listens until no thread works any more.
    pub fn receive(&mut self, events: &Receiver<Event>) {
        loop {
            let event = match self.patience() {
                Some(time) => events.recv_timeout(time),
                None => events.recv().map_err(RecvTimeoutError::from),
            };
            match event {
                Ok(Event::Started { index, at, cancellation }) => self.started(index, at, cancellation),
                Ok(Event::Finished { index, finished }) => self.finished(index, *finished),
                Ok(Event::Interrupt) => self.interrupted(),
                Ok(Event::Drained) | Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => self.progress.tick(),
            }
            self.end_overdue();
        }
        self.progress.end();
    }

    /// All finished runs in the order of the plan.
    ///
    /// # Errors
    /// `runs.jsonl` could not be written.
    pub fn collect(self) -> Result<Collected, RecordError> {
        match self.failure {
            Some(error) => Err(error),
            None => {
                Ok(Collected { finished: self.finished.into_values().collect(), interrupted: self.interruptions > 0 })
            }
        }
    }

    /// How long nothing needs to be done unless something happens.
    fn patience(&self) -> Option<Duration> {
        let now = Instant::now();
        let deadlines = self.active.values().filter_map(|a| a.deadline);
        let next = deadlines.map(|at| at.saturating_duration_since(now)).min();
        next.into_iter().chain(self.progress.tick_interval()).min()
    }

    fn started(&mut self, index: usize, at: Instant, cancellation: Arc<Cancellation>) {
        if self.interruptions > 1 {
            cancellation.cancel(Reason::Interrupted);
        }
        let deadline = self.options.timeout.and_then(|limit| at.checked_add(limit));
        self.active.insert(index, Active { cancellation, deadline });
        self.progress.started(self.active.len());
    }

    fn finished(&mut self, index: usize, finished: Finished) {
        self.active.remove(&index);
        if let Err(error) = self.runs_log.push(&finished.row) {
            // Results that leave no trace are not worth computing.
            self.gate.close();
            self.failure.get_or_insert(error);
        }
        let (done, runs) = (self.finished.len() + 1, self.plan.jobs.len());
        self.progress.finished(&self.plan.jobs[index], &finished, done, runs);
        self.finished.insert(index, finished);
    }

    fn interrupted(&mut self) {
        self.interruptions += 1;
        self.gate.close();
        let running = self.active.len();
        match self.interruptions {
            1 => {
                let plural = if running == 1 { "run" } else { "runs" };
                self.progress.say(&format!(
                    "interrupted: no more runs are started, {running} {plural} being finished; again to cancel them"
                ));
            }
            2 => {
                self.progress.say("interrupted again: running runs are cancelled");
                self.active.values().for_each(|a| a.cancellation.cancel(Reason::Interrupted));
            }
            _ => {}
        }
    }

    fn end_overdue(&mut self) {
        let now = Instant::now();
        for active in self.active.values_mut() {
            if active.deadline.is_some_and(|at| at <= now) {
                active.deadline = None;
                active.cancellation.cancel(Reason::TimedOut);
            }
        }
    }
}
