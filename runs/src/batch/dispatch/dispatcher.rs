//! Event dispatcher: orders events from worker threads, times runs, and owns progress output.

use crate::files::names;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use crate::batch::dispatch::cancellation::Gate;
use crate::batch::dispatch::event::{Event, Work};
use crate::batch::dispatch::finished_runs::Store;
use crate::batch::run::run_timer::{self, Lap};
use crate::batch::{Cancellation, Finished, Job, Listener, Options, Plan, Progress, Reason, Resumed};
use crate::files::{RecordError, modified};
use crate::results::RunRecord;
use crate::sim::{Outcome, RunError};
use crate::text::plural::plural;

/// A run that has started and not finished.
struct Active {
    /// None for a repetition.
    job: Option<Arc<Job>>,
    cancellation: Arc<Cancellation>,
    /// Instant at which its time limit expires; none without a limit, and once it has expired.
    deadline: Option<Instant>,
    /// Instant at which to report it as slow; none without a limit, and once it is reported.
    slow: Option<Instant>,
}

/// Results collected by the dispatcher.
pub(in crate::batch) struct Collected {
    pub finished: Store,
    pub references: Store,
    pub interrupted: bool,
}

/// Processes the events of a batch in order.
pub(in crate::batch) struct Dispatcher<'a> {
    plan: &'a Plan,
    options: &'a Options,
    gate: &'a Gate,
    progress: Progress,
    listener: &'a mut dyn Listener,
    active: BTreeMap<Work, Active>,
    finished: Store,
    references: Store,
    /// Runs to be repeated for timing.
    to_repeat: Vec<usize>,
    laps: BTreeMap<usize, Vec<Lap>>,
    /// Notes on failed repetitions, by run.
    notes: BTreeMap<usize, Vec<String>>,
    interruptions: u32,
    failure: Option<RecordError>,
}

impl<'a> Dispatcher<'a> {
    pub fn new(
        plan: &'a Plan,
        options: &'a Options,
        gate: &'a Gate,
        progress: Progress,
        listener: &'a mut dyn Listener,
        resumed: Resumed,
    ) -> Self {
        let Resumed { finished, references, to_repeat, .. } = resumed;
        progress.skipped(finished.count + references.count);
        Self {
            plan,
            options,
            gate,
            progress,
            listener,
            active: BTreeMap::new(),
            finished,
            references,
            to_repeat,
            laps: BTreeMap::new(),
            notes: BTreeMap::new(),
            interruptions: 0,
            failure: None,
        }
    }

    /// Processes events until all threads have finished.
    pub fn receive(&mut self, events: &Receiver<Event>) {
        loop {
            let event = match self.receive_timeout() {
                Some(time) => events.recv_timeout(time),
                None => events.recv().map_err(RecvTimeoutError::from),
            };
            match event {
                Err(RecvTimeoutError::Timeout) => self.progress.tick(),
                Err(RecvTimeoutError::Disconnected) => break,
                Ok(first) => {
                    if std::iter::once(first)
                        .chain(events.try_iter().take(MOST_EVENTS))
                        .any(|event| self.receive_one(event))
                    {
                        break;
                    }
                    std::thread::sleep(PAUSE);
                }
            }
            self.cancel_overdue();
            self.report_slow();
        }
    }

    /// True if it is the last event.
    fn receive_one(&mut self, event: Event) -> bool {
        match event {
            Event::Started { work, job, at, cancellation } => self.started(work, job, at, cancellation),
            Event::Finished { work, finished, unlisted } => self.finished(work, *finished, unlisted),
            Event::Round { round, rounds, runs } => self.progress.round(round, rounds, runs),
            Event::Timed { index, lap } => self.timed(index, lap),
            Event::Interrupt => self.interrupted(),
            Event::Drained => return true,
        }
        false
    }

    /// Takes the runs to repeat for timing; none if the gate is closed or timing is off.
    pub fn take_repeats(&mut self) -> Vec<usize> {
        if self.gate.is_closed() || !self.options.timing {
            return Vec::new();
        }
        self.to_repeat.sort_unstable();
        std::mem::take(&mut self.to_repeat)
    }

    /// Writes repeated timings into the records and returns all finished runs, in plan order.
    ///
    /// # Errors
    /// `runs.jsonl` could not be written, or a record with its timings.
    pub fn collect(mut self) -> Result<Collected, RecordError> {
        self.progress.end();
        if let Some(error) = self.failure {
            return Err(error);
        }
        for (index, laps) in &self.laps {
            let path = self.plan.folder(*index, &self.options.output).join(names::RUN_RECORD);
            let mut record = RunRecord::read(&path)?;
            record.timing.repeats = run_timer::repeats(laps);
            record.notes.extend(self.notes.remove(index).into_iter().flatten());
            record.write(&path)?;
            if let Some(finished) = self.finished.get_mut(*index) {
                finished.recorded = modified(&path);
                finished.row.repeats = record.timing.repeats;
                finished.notes = record.notes;
            }
        }
        for (index, notes) in self.notes {
            self.finished.get_mut(index).into_iter().for_each(|finished| finished.notes.extend(notes.iter().cloned()));
        }
        Ok(Collected { finished: self.finished, references: self.references, interrupted: self.interruptions > 0 })
    }

    /// Time until the next deadline or progress tick.
    fn receive_timeout(&self) -> Option<Duration> {
        let now = Instant::now();
        let deadlines = self.active.values().flat_map(|a| [a.deadline, a.slow]).flatten();
        let next = deadlines.map(|at| at.saturating_duration_since(now)).min();
        next.into_iter().chain(self.progress.tick_interval()).min()
    }

    fn started(&mut self, work: Work, job: Option<Arc<Job>>, at: Instant, cancellation: Arc<Cancellation>) {
        if self.interruptions > 1 {
            cancellation.cancel(Reason::Interrupted);
        }
        let after = |limit: Option<Duration>| limit.and_then(|limit| at.checked_add(limit));
        let deadline = after(self.options.timeout);
        // Repetitions have no job here and are not reported.
        let slow = after(self.options.slow.filter(|_| job.is_some()));
        if let Some(job) = &job {
            self.progress.started(self.active.len() + 1);
            self.listener.started(job);
        }
        self.active.insert(work, Active { job, cancellation, deadline, slow });
    }

    fn finished(&mut self, work: Work, finished: Finished, unlisted: Option<RecordError>) {
        // Every finished job was started.
        let Some(job) = self.active.remove(&work).and_then(|active| active.job) else { return };
        let is_run = matches!(work, Work::Run(_));
        if let Some(error) = unlisted {
            // The run's thread has closed the gate.
            self.failure.get_or_insert(error);
        }
        if finished.storage_full {
            // Its thread has closed the gate here too.
            self.failure.get_or_insert(RecordError::StorageFull { what: finished.row.message.clone() });
        } else if finished.row.outcome == Outcome::Error
            && let Err(source) = writable(&self.options.output)
        {
            // Further runs would fail in the same way.
            self.gate.close();
            let (what, folder) = (finished.row.message.clone(), self.options.output.clone());
            self.failure.get_or_insert(RecordError::NoRoom { what, folder, source });
        }
        let done = self.finished.count + self.references.count + 1;
        self.progress.finished(&job, &finished, done, self.plan.runs() + self.plan.references());
        self.listener.finished(&job, &finished);
        if is_run && finished.needs_repetitions(&job) {
            self.to_repeat.push(job.index);
        }
        if is_run { &mut self.finished } else { &mut self.references }.insert(job.index, finished);
    }

    fn timed(&mut self, index: usize, lap: Result<Lap, RunError>) {
        self.active.remove(&Work::Repetition(index));
        self.progress.timed();
        match lap {
            Ok(lap) => self.laps.entry(index).or_default().push(lap),
            Err(error) => {
                let note = format!("a repetition for timing failed: {}", error.with_outcome());
                self.notes.entry(index).or_default().push(note);
            }
        }
    }

    fn interrupted(&mut self) {
        self.interruptions += 1;
        self.gate.close();
        let running = self.active.len();
        match self.interruptions {
            1 => {
                self.progress.print_line(&format!(
                    "interrupted: no more runs are started, {} being finished; again to cancel them",
                    plural(running, "run")
                ));
            }
            2 => {
                self.progress.print_line("interrupted again: running runs are cancelled");
                self.active.values().for_each(|a| a.cancellation.cancel(Reason::Interrupted));
            }
            _ => {}
        }
    }

    fn report_slow(&mut self) {
        let Some(limit) = self.options.slow else { return };
        let now = Instant::now();
        for active in self.active.values_mut().filter(|a| a.slow.is_some_and(|at| at <= now)) {
            active.slow = None;
            if let Some(job) = &active.job {
                self.progress.slow(job, limit);
                self.listener.slow(job, limit);
            }
        }
    }

    fn cancel_overdue(&mut self) {
        let now = Instant::now();
        for active in self.active.values_mut() {
            if active.deadline.is_some_and(|at| at <= now) {
                active.deadline = None;
                active.cancellation.cancel(Reason::TimedOut);
            }
        }
    }
}

/// Most events received before time limits are checked.
const MOST_EVENTS: usize = 256;

/// Pause between events that are received together. To wake this thread for each costs a tenth of the
/// time of runs of 0.3 ms.
const PAUSE: Duration = Duration::from_millis(1);

/// Size of the test file, bytes. It exceeds a directory entry, so a full disk refuses it.
const PROBE: usize = 64 << 10;

/// Checks that the folder accepts a file of `PROBE` bytes.
fn writable(folder: &Path) -> std::io::Result<()> {
    tempfile::tempfile_in(folder)?.write_all(&[0; PROBE])
}
