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

mod audience;
mod cancel;
mod clock;
mod dispatch;
mod event;
mod execute;
mod filter;
mod finding;
mod guard;
mod judge;
mod junit;
mod keys;
mod listen;
mod message;
mod plan;
mod planner;
mod progress;
mod repeat;
mod resume;
mod robots;
mod run;
mod schedule;
mod shard;
mod simulate;
mod stale;
mod store;

use crate::files::names;
use std::cell::RefCell;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use crate::files::{RecordError, confined, remove_partial};
use crate::report::{Pictured, ReportRun, write_report_of};
use crate::results::{
    Machine, PROGRAM, ReferenceMotion, RunStatistics, RunsLog, SummaryFiles, SummaryRow, write_summary_of,
};
use crate::sim::{Outcome, Problems};

pub use crate::text::Severity;
pub use audience::Audience;
pub use cancel::{Cancellation, Reason};
pub use filter::{Filter, Selection};
pub use finding::{Finding, Findings};
pub use junit::{Junit, is_slow};
pub use listen::{Listener, Nobody};
pub use message::{
    BatchFinished, BatchStarted, CheckFinished, DiagnosticMessage, MESSAGE_SCHEMA, Message, Teller, message_schema,
};
pub use plan::{Job, Plan, Role};
pub use planner::{prepare, prepare_file};
pub use progress::Progress;
pub use resume::{Again, Resumed};
pub use run::End;
pub use shard::{Part, Shard};
pub(crate) use simulate::{open_log_of, topics};
pub use simulate::{simulate, simulate_before, simulate_for};

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
    /// Start no more runs once so many failed or did not finish; none: start all.
    pub max_fail: Option<NonZero<usize>>,
    /// Wall-clock time after which a run that is still going is told of as slow.
    pub slow: Option<Duration>,
    /// Contact problems to write below each run's folder.
    pub problems: Problems,
    /// Repeat runs whose scenarios ask for it, to time them?
    pub timing: bool,
    /// Make only those runs whose results are not there?
    pub resume: bool,
}

impl Default for Options {
    /// Results in `results`, one thread per processor, logs where scenarios want them, no limits.
    fn default() -> Self {
        Self {
            output: PathBuf::from("results"),
            jobs: std::thread::available_parallelism().map_or(1, NonZero::get),
            log: true,
            timeout: None,
            max_fail: None,
            slow: None,
            problems: Problems::None,
            timing: true,
            resume: false,
        }
    }
}

/// What can go wrong with a batch as a whole; a run's own troubles are its outcome.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// The output folder cannot be used; nothing has run.
    #[error("cannot write results into {}: {source}; --output names a folder for them", folder.display())]
    Output {
        /// The folder.
        folder: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A robot cannot do two things at once, and stays where a run has left it.
    #[error(
        "a robot that is somewhere else (`robot.backend`) makes one run, and this asks for it {0} times: choose one with \
         --filter or --set, without `compare`"
    )]
    Robots(usize),
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
    /// Numbers of all finished runs.
    pub statistics: RunStatistics,
    /// Finished runs in the order of the plan: all of them unless they are more than [`SAMPLE_SIZE`](crate::results::SAMPLE_SIZE),
    /// else the first of those that went wrong and of the others.
    pub finished: Vec<Finished>,
    /// How many of all finished runs did not end as they should, those apart of which an expectation did not hold.
    pub unfinished: usize,
    /// Of how many an expectation did not hold.
    pub failed: usize,
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
        let mut refused = self.references.iter().filter(|f| !f.accepted);
        self.unfinished > 0
            || refused.any(|f| !matches!(f.row.outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen))
    }

    /// Did an expectation not hold?
    pub fn has_failed(&self) -> bool {
        self.failed > 0
    }

    /// The rows of the summary that are at hand.
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
    resumed: Resumed,
    events: (Sender<Event>, Receiver<Event>),
}

impl Batch {
    /// Makes sure of the output folder, and looks for what is done already if that is wanted. From here on no summary of an
    /// earlier batch is there.
    ///
    /// # Errors
    /// The folder cannot be created or written, or another program is writing there.
    pub fn new(plan: Plan, options: Options) -> Result<Self, BatchError> {
        if plan.visits() > 1 {
            return Err(BatchError::Robots(plan.visits()));
        }
        let refused = |source| BatchError::Output { folder: options.output.clone(), source };
        std::fs::create_dir_all(&options.output).map_err(refused)?;
        // The summary is written at the end; that its folder takes files must be known now.
        tempfile::tempfile_in(&options.output).map_err(refused)?;
        let runs_log_path = options.output.join(names::RUNS_LOG);
        let mut runs_log = RunsLog::append(&runs_log_path)?;
        // Told now and not by each run.
        for scenario in plan.scenarios() {
            let folder = options.output.join(scenario);
            confined::check(&options.output, &folder.join(names::REFERENCES))?;
            // Where others may not write, all of its runs would fail.
            if folder.is_dir() {
                tempfile::tempfile_in(&folder).map_err(RecordError::io(&folder))?;
            }
        }
        remove_partial(&options.output);
        for name in names::BATCH_OUTPUTS {
            let path = options.output.join(name);
            match std::fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(RecordError::io(&path)(error).into());
                }
                _ => {}
            }
        }
        if let Some(part) = &plan.part {
            part.head.write(&options.output, plan.shard_runs())?;
        }
        let resumed = if options.resume { resume::look(&plan, &options) } else { Resumed::default() };
        if resumed.runs() > 0 {
            // Between a run's record and its line the program may have been killed.
            let told = RunsLog::logged(&runs_log_path)?;
            for index in resumed.finished.positions() {
                if !told.contains(plan.scenario(index), &plan.key(index)) {
                    runs_log.push(&resumed.finished.row(index, &plan, &options.output)?)?;
                }
            }
        }
        Ok(Self { plan, options, runs_log, runs_log_path, resumed, events: channel() })
    }

    /// What is there already.
    pub fn resumed(&self) -> &Resumed {
        &self.resumed
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
    pub fn run(self, progress: Progress, body: &Body<'_>) -> Result<Report, BatchError> {
        self.run_told(progress, &mut Nobody, body)
    }

    /// The same, and `listener` is told what happens.
    ///
    /// # Errors
    /// See [`Batch::run`].
    pub fn run_told(
        mut self,
        progress: Progress,
        listener: &mut dyn Listener,
        body: &Body<'_>,
    ) -> Result<Report, BatchError> {
        let gate = cancel::Gate::default();
        let (sender, inbox) = self.events;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.options.jobs.clamp(1, (self.plan.runs() + self.plan.references()).max(1)))
            .thread_name(|i| format!("run-{i}"))
            .build()?;
        let (plan, output) = (&self.plan, &self.options.output);
        if listener.listens() {
            for (store, job) in self.resumed.all(plan) {
                listener.kept(&job, &store.finished(&job, output)?);
            }
        }
        let schedule = schedule::Schedule::new(plan, &self.resumed);
        let (options, resumed) = (&self.options, self.resumed);
        let mut dispatcher =
            dispatch::Dispatcher::new(plan, options, &gate, &mut self.runs_log, progress, listener, resumed);
        std::thread::scope(|scope| {
            scope.spawn(|| execute::execute(&pool, &self.plan, &self.options, &schedule, &gate, &sender, body));
            dispatcher.receive(&inbox);
            let again = dispatcher.take_repeats();
            if !again.is_empty() {
                let (plan, gate, sender) = (&self.plan, &gate, &sender);
                scope.spawn(move || repeat::repeat(plan, &again, gate, sender));
                dispatcher.receive(&inbox);
            }
        });
        let dispatch::Collected { finished: store, references, interrupted } = dispatcher.collect()?;
        let rows = store::AllRows { store: &store, plan, output, statistics: RefCell::default() };
        let summary = if store.count == 0 { None } else { Some(write_summary_of(output, &rows)?) };
        let (count, statistics) = (store.count, rows.statistics.into_inner().unwrap_or_default());
        let (unfinished, failed) = (store.unfinished, store.failed);
        let (finished, references) = (store.into_kept(), references.into_kept());
        let page = if count == 0 { None } else { Some(write_page(output, &finished, &statistics, &references)?) };
        Ok(Report {
            not_started: self.plan.runs() - count,
            statistics,
            finished,
            unfinished,
            failed,
            references,
            interrupted,
            summary,
            page,
            runs_log: self.runs_log_path,
        })
    }
}

/// Writes `report.html`.
fn write_page(
    output: &Path,
    finished: &[Finished],
    statistics: &RunStatistics,
    references: &[Finished],
) -> Result<PathBuf, RecordError> {
    let (page, machine) = (output.join(names::REPORT), Machine::here());
    let runs = as_reported(finished, &machine);
    write_report_of(&page, output, (&runs, statistics), &as_reported(references, &machine), &Pictured::Few)?;
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
