//! The one who is told everything: keeps the order, the clock of each run, and the only voice.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use super::cancel::Gate;
use super::clock::{self, Lap};
use super::event::{Event, Work};
use super::{Cancellation, Finished, Job, Listener, Options, Plan, Progress, Reason};
use crate::record::{RecordError, RunRecord, RunsLog};
use crate::sim::Outcome;

/// A run that has started and not finished.
struct Active {
    cancellation: Arc<Cancellation>,
    /// When its time is up; none: never, or it has been told already.
    deadline: Option<Instant>,
    /// The same for telling that it is slow.
    slow: Option<Instant>,
}

/// What was collected.
pub(super) struct Collected {
    /// In the order of the plan.
    pub finished: Vec<Finished>,
    /// The same for references.
    pub references: Vec<Finished>,
    pub interrupted: bool,
}

/// Linearises what happens in a batch.
pub(super) struct Dispatcher<'a> {
    plan: &'a Plan,
    options: &'a Options,
    gate: &'a Gate,
    runs_log: &'a mut RunsLog,
    progress: Progress,
    listener: &'a mut dyn Listener,
    active: BTreeMap<Work, Active>,
    finished: BTreeMap<usize, Finished>,
    references: BTreeMap<usize, Finished>,
    laps: BTreeMap<usize, Vec<Lap>>,
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
        listener: &'a mut dyn Listener,
    ) -> Self {
        Self {
            plan,
            options,
            gate,
            runs_log,
            progress,
            listener,
            active: BTreeMap::new(),
            finished: BTreeMap::new(),
            references: BTreeMap::new(),
            laps: BTreeMap::new(),
            interruptions: 0,
            failure: None,
        }
    }

    /// Listens until no thread works any more.
    pub fn receive(&mut self, events: &Receiver<Event>) {
        loop {
            let event = match self.patience() {
                Some(time) => events.recv_timeout(time),
                None => events.recv().map_err(RecvTimeoutError::from),
            };
            match event {
                Ok(Event::Started { work, at, cancellation }) => self.started(work, at, cancellation),
                Ok(Event::Finished { work, finished }) => self.finished(work, *finished),
                Ok(Event::Round { round, rounds, runs }) => self.progress.round(round, rounds, runs),
                Ok(Event::Timed { index, lap }) => self.timed(index, lap),
                Ok(Event::Interrupt) => self.interrupted(),
                Ok(Event::Drained) | Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => self.progress.tick(),
            }
            self.end_overdue();
            self.tell_slow();
        }
    }

    /// The runs to be repeated for timing: those that ended by themselves, unless no more shall begin.
    pub fn to_repeat(&self) -> Vec<&'a Job> {
        if self.gate.is_closed() || !self.options.timing {
            return Vec::new();
        }
        let whole = |f: &Finished| matches!(f.row.outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen);
        let finished = self.finished.iter().filter(|(_, f)| whole(f)).map(|(index, _)| &self.plan.jobs[*index]);
        finished.filter(|job| job.repetitions() > 0).collect()
    }

    /// All finished runs in the order of the plan.
    ///
    /// # Errors
    /// `runs.jsonl` could not be written, or a record with its timings.
    pub fn collect(mut self) -> Result<Collected, RecordError> {
        self.progress.end();
        if let Some(error) = self.failure {
            return Err(error);
        }
        for (index, laps) in &self.laps {
            let Some(finished) = self.finished.get_mut(index) else { continue };
            let path = self.plan.jobs[*index].folder(&self.options.output).join("run.json");
            let mut record = RunRecord::read(&path)?;
            record.timing.repeats = clock::repeats(laps);
            finished.row.repeats = record.timing.repeats;
            record.notes.clone_from(&finished.notes);
            record.write(&path)?;
        }
        Ok(Collected {
            finished: self.finished.into_values().collect(),
            references: self.references.into_values().collect(),
            interrupted: self.interruptions > 0,
        })
    }

    /// How long nothing needs to be done unless something happens.
    fn patience(&self) -> Option<Duration> {
        let now = Instant::now();
        let deadlines = self.active.values().flat_map(|a| [a.deadline, a.slow]).flatten();
        let next = deadlines.map(|at| at.saturating_duration_since(now)).min();
        next.into_iter().chain(self.progress.tick_interval()).min()
    }

    fn started(&mut self, work: Work, at: Instant, cancellation: Arc<Cancellation>) {
        if self.interruptions > 1 {
            cancellation.cancel(Reason::Interrupted);
        }
        let after = |limit: Option<Duration>| limit.and_then(|limit| at.checked_add(limit));
        let deadline = after(self.options.timeout);
        let is_repetition = matches!(work, Work::Repetition(_));
        let slow = after(self.options.slow.filter(|_| !is_repetition));
        self.active.insert(work, Active { cancellation, deadline, slow });
        if !is_repetition {
            self.progress.started(self.active.len());
            self.listener.started(self.job(work));
        }
    }

    fn finished(&mut self, work: Work, finished: Finished) {
        self.active.remove(&work);
        let job = self.job(work);
        let is_run = matches!(work, Work::Run(_));
        if is_run && let Err(error) = self.runs_log.push(&finished.row) {
            // Results that leave no trace are not worth computing.
            self.gate.close();
            self.failure.get_or_insert(error);
        }
        let done = self.finished.len() + self.references.len() + 1;
        self.progress.finished(job, &finished, done, self.plan.jobs.len() + self.plan.references.len());
        self.listener.finished(job, &finished);
        if is_run { &mut self.finished } else { &mut self.references }.insert(job.index, finished);
    }

    fn timed(&mut self, index: usize, lap: Result<Lap, String>) {
        self.active.remove(&Work::Repetition(index));
        self.progress.timed();
        match lap {
            Ok(lap) => self.laps.entry(index).or_default().push(lap),
            Err(reason) => {
                if let Some(finished) = self.finished.get_mut(&index) {
                    finished.notes.push(format!("a repetition for timing came to nothing: {reason}"));
                }
            }
        }
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

    fn tell_slow(&mut self) {
        let Some(limit) = self.options.slow else { return };
        let now = Instant::now();
        let overdue: Vec<Work> =
            self.active.iter().filter(|(_, a)| a.slow.is_some_and(|at| at <= now)).map(|(work, _)| *work).collect();
        for work in overdue {
            self.active.entry(work).and_modify(|a| a.slow = None);
            let job = self.job(work);
            self.progress.slow(job, limit);
            self.listener.slow(job, limit);
        }
    }

    fn job(&self, work: Work) -> &'a Job {
        match work {
            Work::Reference(index) => &self.plan.references[index],
            Work::Run(index) | Work::Repetition(index) => &self.plan.jobs[index],
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
