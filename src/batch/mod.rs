//! Many runs side by side.
//!
//! ```text
//! files -> prepare -> Plan of Jobs -> execute (a pool of threads) -> Events -> dispatch -> rows, progress, summary
//!                                  -> repeat (one thread, for timing) ->
//! ```
//!
//! [`prepare`] checks everything before anything runs. [`Batch::run`] drives the jobs: the threads of the executor
//! simulate and write what belongs to one run; one dispatcher receives what they tell, and only it prints, appends to
//! `runs.jsonl` and collects the rows, which stand in the order of the plan whatever the order of finishing. Runs that others
//! are compared with are references: work like the others, each done once, before the runs that need it.

mod cancel;
mod clock;
mod dispatch;
mod event;
mod execute;
mod finding;
mod guard;
mod judge;
mod keys;
mod plan;
mod progress;
mod repeat;
mod robots;
mod run;
mod schedule;
mod simulate;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::record::{
    Machine, PROGRAM, Pictured, RecordError, ReferenceMotion, ReportRun, RunsLog, SummaryFiles, SummaryRow,
    write_report, write_summary,
};
use crate::sim::{Outcome, Problems};

pub use cancel::{Cancellation, Reason};
pub use finding::{Finding, Findings, Severity};
pub use plan::{Job, Plan, Role, prepare, prepare_file};
pub use progress::Progress;
pub use run::End;
pub use simulate::simulate;

use event::Event;

/// How a batch is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder of the results; created if need be.
    pub output: PathBuf,
    /// Threads, at least 1.
    pub jobs: usize,
    /// Write `log.mcap` where the scenario wants one?
    pub log: bool,
    /// Wall-clock limit of each run.
    pub timeout: Option<Duration>,
    /// Start no more runs after the first that failed or did not finish?
    pub fail_fast: bool,
    /// Contact problems to write below each run's folder.
    pub problems: Problems,
    /// Repeat runs whose scenarios ask for it, to time them?
    pub timing: bool,
}

/// What can go wrong with a batch as a whole; a run's own troubles are its outcome.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// The output folder cannot be used; nothing has run.
    #[error("cannot write results into {}: {source}", folder.display())]
    Output {
        /// The folder.
        folder: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A record of the batch cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The threads cannot be started.
    #[error("cannot start the threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The files it left: `run.json`, and `log.mcap` and the folder `problems` if they are there.
    pub files: Vec<PathBuf>,
    /// What else there is to tell a person.
    pub notes: Vec<String>,
    /// Its row of the summary.
    pub row: SummaryRow,
    /// It ended as it should: `passed`, `fallen` with every expectation held, or in the way that an expectation names.
    pub accepted: bool,
}

/// What a batch came to.
#[derive(Clone, Debug)]
pub struct Report {
    /// Finished runs in the order of the plan.
    pub finished: Vec<Finished>,
    /// Finished reference runs, in the order in which they are first needed; they have no row in the summary.
    pub references: Vec<Finished>,
    /// Runs that were never started.
    pub not_started: usize,
    /// Was it interrupted?
    pub interrupted: bool,
    /// The summary's files; none when no run finished.
    pub summary: Option<SummaryFiles>,
    /// `report.html`; none when no run finished.
    pub page: Option<PathBuf>,
    /// `runs.jsonl`.
    pub runs_log: PathBuf,
}

impl Report {
    /// Did some run not reach its end, other than as expected?
    pub fn has_unfinished(&self) -> bool {
        let mut refused = self.finished.iter().chain(&self.references).filter(|f| !f.accepted);
        refused.any(|f| !matches!(f.row.outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen))
    }

    /// Did an expectation not hold?
    pub fn has_failed(&self) -> bool {
        self.finished.iter().any(|f| f.row.outcome == Outcome::Failed)
    }

    /// The rows of the summary.
    pub fn rows(&self) -> Vec<SummaryRow> {
        self.finished.iter().map(|f| f.row.clone()).collect()
    }
}

/// Interrupts a batch from anywhere, such as a signal handler. The first interruption lets running runs finish and
/// starts no more; the second cancels them.
#[derive(Clone)]
pub struct Interrupter(Sender<Event>);

impl Interrupter {
    /// Interrupts.
    pub fn interrupt(&self) {
        // A batch that is over has nothing left to interrupt.
        let _ = self.0.send(Event::Interrupt);
    }
}

/// A plan that is about to run, its output folder at hand.
pub struct Batch {
    plan: Plan,
    options: Options,
    runs_log: RunsLog,
    runs_log_path: PathBuf,
    events: (Sender<Event>, Receiver<Event>),
}

impl Batch {
    /// Makes sure of the output folder.
    ///
    /// # Errors
    /// The folder cannot be created or written.
    pub fn new(plan: Plan, options: Options) -> Result<Self, BatchError> {
        let refused = |source| BatchError::Output { folder: options.output.clone(), source };
        std::fs::create_dir_all(&options.output).map_err(refused)?;
        // The summary is written at the end; that its folder takes files must be known now.
        tempfile::tempfile_in(&options.output).map_err(refused)?;
        let runs_log_path = options.output.join("runs.jsonl");
        let runs_log = RunsLog::append(&runs_log_path)?;
        Ok(Self { plan, options, runs_log, runs_log_path, events: channel() })
    }

    /// A handle that interrupts this batch.
    pub fn interrupter(&self) -> Interrupter {
        Interrupter(self.events.0.clone())
    }

    /// Runs all jobs with `body`, which is [`simulate`] unless a test wants something else to happen, and writes the
    /// summary of those that finished.
    ///
    /// # Errors
    /// Threads cannot be started, or a file of the batch cannot be written. Runs that finished keep their records.
    pub fn run(mut self, progress: Progress, body: &Body<'_>) -> Result<Report, BatchError> {
        let gate = cancel::Gate::default();
        let (sender, inbox) = self.events;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.options.jobs.clamp(1, (self.plan.jobs.len() + self.plan.references.len()).max(1)))
            .thread_name(|i| format!("run-{i}"))
            .build()?;
        let mut dispatcher = dispatch::Dispatcher::new(&self.plan, &self.options, &gate, &mut self.runs_log, progress);
        std::thread::scope(|scope| {
            scope.spawn(|| execute::execute(&pool, &self.plan, &self.options, &gate, &sender, body));
            dispatcher.receive(&inbox);
            let again = dispatcher.to_repeat();
            if !again.is_empty() {
                let (gate, sender) = (&gate, &sender);
                scope.spawn(move || repeat::repeat(&again, gate, sender));
                dispatcher.receive(&inbox);
            }
        });
        let collected = dispatcher.collect()?;
        let rows: Vec<SummaryRow> = collected.finished.iter().map(|f| f.row.clone()).collect();
        let summary = if rows.is_empty() { None } else { Some(write_summary(&self.options.output, &rows)?) };
        let page = if rows.is_empty() { None } else { Some(write_page(&self.options.output, &collected)?) };
        Ok(Report {
            not_started: self.plan.jobs.len() - collected.finished.len(),
            finished: collected.finished,
            references: collected.references,
            interrupted: collected.interrupted,
            summary,
            page,
            runs_log: self.runs_log_path,
        })
    }
}

/// Writes `report.html`.
fn write_page(output: &Path, collected: &dispatch::Collected) -> Result<PathBuf, RecordError> {
    let (page, machine) = (output.join("report.html"), Machine::here());
    write_report(
        &page,
        output,
        &as_reported(&collected.finished, &machine),
        &as_reported(&collected.references, &machine),
        &Pictured::Few,
    )?;
    Ok(page)
}

fn as_reported<'a>(finished: &'a [Finished], machine: &'a Machine) -> Vec<ReportRun<'a>> {
    let run = |f: &'a Finished| ReportRun { row: &f.row, program: PROGRAM, machine, notes: &f.notes, files: &f.files };
    finished.iter().map(run).collect()
}

/// What a run shall leave besides its record.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Where its log goes; none: no log.
    pub log: Option<PathBuf>,
    /// The folder of its contact problems; none: they are not wanted.
    pub problems: Option<(PathBuf, Problems)>,
    /// What becomes of its motion.
    pub track: Track,
}

/// What becomes of a run's motion.
#[derive(Clone, Debug, Default)]
pub enum Track {
    /// Nothing.
    #[default]
    Nothing,
    /// It is kept for others to be compared with, at so many samples per second, Hz.
    Keep(f64),
    /// It is compared with a reference.
    Compare(Arc<ReferenceMotion>),
}

/// What happens in a run: the job, what it shall leave, and the flag that ends it.
pub type Body<'a> = dyn Fn(&Job, &Wanted, &std::sync::atomic::AtomicBool) -> End + Sync + 'a;
