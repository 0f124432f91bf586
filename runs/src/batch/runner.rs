//! Runs the jobs of a plan on worker threads, then writes summary and report.

use std::io::Write;
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};

use crate::batch::dispatch::cancellation::Gate;
use crate::batch::dispatch::claim_watch::ClaimWatch;
use crate::batch::dispatch::dispatcher::{Collected, Dispatcher};
use crate::batch::dispatch::event::Event;
use crate::batch::dispatch::finished_runs::AllRows;
use crate::batch::dispatch::repetitions;
use crate::batch::dispatch::schedule::Schedule;
use crate::batch::dispatch::search_watch::SearchWatch;
use crate::batch::dispatch::workers::Workers;
use crate::batch::resume::resumed;
use crate::batch::{
    BatchError, Body, Listener, NoListener, Options, PageText, Plan, Progress, Report, Resumed, ShownResults,
};
use crate::files::{RecordError, atomic, confined, if_present, names, remove_partial};
use crate::results::claims::write_claims;
use crate::results::searches::write_searches;
use crate::results::{RunsLog, ShardHead};

/// Calls `work` in a pool of `jobs` threads, but of at least one and at most one per processor.
///
/// # Errors
/// The threads cannot be started.
pub fn on_threads<T: Send>(jobs: usize, work: impl FnOnce() -> T + Send) -> Result<T, BatchError> {
    let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    Ok(rayon::ThreadPoolBuilder::new().num_threads(jobs.clamp(1, processors)).build()?.install(work))
}

/// Interrupts a batch from anywhere, such as a signal handler. The first interruption starts no
/// more runs; the second cancels active ones.
#[derive(Clone)]
pub struct Interrupter(Sender<Event>);

impl Interrupter {
    /// Sends an interruption.
    pub fn interrupt(&self) {
        // A finished batch no longer receives events.
        let _ = self.0.send(Event::Interrupt);
    }
}

/// A plan with its prepared output folder, ready to run.
pub struct Batch {
    plan: Plan,
    options: Options,
    page: PageText,
    runs_log: RunsLog,
    runs_log_path: PathBuf,
    resumed: Resumed,
    searches: SearchWatch,
    events: (Sender<Event>, Receiver<Event>),
}

impl Batch {
    /// Prepares the output folder, removes an earlier summary, and finds finished runs to resume. `page`
    /// makes the text of the report.
    ///
    /// # Errors
    /// The folder cannot be created or written, or another program is writing there.
    pub fn new(plan: Plan, options: Options, page: PageText) -> Result<Self, BatchError> {
        if plan.remote_runs() > 1 {
            return Err(BatchError::RemoteRuns(plan.remote_runs()));
        }
        let refused = |source| BatchError::Output { folder: options.output.clone(), source };
        std::fs::create_dir_all(&options.output).map_err(refused)?;
        // The summary is written last, so an unwritable folder is detected now.
        tempfile::tempfile_in(&options.output).map_err(refused)?;
        let runs_log_path = options.output.join(names::RUNS_LOG);
        let runs_log = RunsLog::append(&runs_log_path)?;
        // Detected now rather than by each run.
        for scenario in plan.scenarios() {
            let folder = options.output.join(scenario);
            confined::check(&options.output, &folder.join(names::REFERENCES))?;
            // Without write permission, all of its runs would fail.
            if folder.is_dir() {
                tempfile::tempfile_in(&folder).map_err(RecordError::io(&folder))?;
            }
        }
        remove_partial(&options.output);
        for name in names::BATCH_OUTPUTS {
            let path = options.output.join(name);
            if_present(std::fs::remove_file(&path)).map_err(RecordError::io(&path))?;
        }
        if let Some(part) = &plan.part {
            let unused = (0..plan.runs()).filter(|index| !plan.is_known(*index)).count();
            ShardHead { unused, ..part.head.clone() }.write(&options.output, plan.shard_runs())?;
        }
        let (searches, chosen) = SearchWatch::begin(&plan);
        let resumed = match options.resume {
            true => resumed::find_results(&plan, &options, &searches, chosen)?,
            false => Resumed::default(),
        };
        if resumed.runs() > 0 {
            // The program may have been killed between writing a record and its line.
            let logged = runs_log.logged()?;
            for index in resumed.finished.positions() {
                if !logged.contains(plan.scenario(index), &plan.key(index)) {
                    runs_log.push(&*resumed.finished.row(index, &plan, &options.output)?)?;
                }
            }
        }
        Ok(Self { plan, options, page, runs_log, runs_log_path, resumed, searches, events: channel() })
    }

    /// Results found by `--resume`.
    pub fn resumed(&self) -> &Resumed {
        &self.resumed
    }

    /// A handle that interrupts this batch.
    pub fn interrupter(&self) -> Interrupter {
        Interrupter(self.events.0.clone())
    }

    /// Runs all jobs with `body` (normally [`super::simulate`]) and summarises finished runs.
    ///
    /// # Errors
    /// Threads cannot be started, or a file of the batch cannot be written. Runs that finished keep
    /// their records.
    pub fn run(self, progress: Progress, body: &Body<'_>) -> Result<Report, BatchError> {
        self.run_with_listener(progress, &mut NoListener, body)
    }

    /// Like [`Batch::run`], reporting events to `listener`.
    ///
    /// # Errors
    /// See [`Batch::run`].
    pub fn run_with_listener(
        self,
        progress: Progress,
        listener: &mut dyn Listener,
        body: &Body<'_>,
    ) -> Result<Report, BatchError> {
        let gate = Gate::default();
        let (sender, inbox) = self.events;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.options.jobs.clamp(1, (self.plan.runs() + self.plan.references()).max(1)))
            .thread_name(|i| format!("run-{i}"))
            .build()?;
        let (plan, output) = (&self.plan, &self.options.output);
        if listener.is_active() {
            for (store, job) in self.resumed.all(plan) {
                listener.resumed(&job, &store.finished(&job, output)?);
            }
        }
        let schedule = Schedule::new(plan, &self.resumed);
        let claims = ClaimWatch::new(plan, &self.resumed.finished, output)?;
        schedule.drop_runs(&|index| !claims.needs(index));
        let (options, resumed, searches) = (&self.options, self.resumed, &self.searches);
        let (schedule, claims, runs_log) = (&schedule, &claims, &self.runs_log);
        let workers = Workers { plan, options, schedule, claims, searches, runs_log, gate: &gate, body };
        let mut dispatcher = Dispatcher::new(plan, options, &gate, progress, listener, resumed);
        std::thread::scope(|scope| {
            scope.spawn(|| workers.work(&pool, &sender));
            dispatcher.receive(&inbox);
            let to_repeat = dispatcher.take_repeats();
            if !to_repeat.is_empty() {
                let (plan, gate, sender) = (&self.plan, &gate, &sender);
                scope.spawn(move || repetitions::repeat(plan, &to_repeat, gate, sender));
                dispatcher.receive(&inbox);
            }
        });
        let Collected { finished: store, references, interrupted } = dispatcher.collect()?;
        let open = || (0..plan.runs()).filter(|index| plan.is_known(*index) && !store.is_done(*index));
        let unneeded = open().filter(|index| !claims.needs(*index));
        let not_needed = unneeded.inspect(|index| listener.not_needed(*index)).count();
        let not_started = open().count() - not_needed;
        let found = searches.results(plan);
        found.iter().for_each(|search| listener.searched(search));
        let search_files = write_searches(output, &found)?;
        if let Some(part) = plan.part.as_ref().filter(|_| plan.has_search()) {
            let head = ShardHead { unused: searches.unused(plan), searches: found.clone(), ..part.head.clone() };
            head.write(output, plan.shard_runs())?;
        }
        let verdicts = claims.verdicts();
        verdicts.iter().for_each(|verdict| listener.judged(verdict));
        let claims_file = write_claims(output, &verdicts, claims.changes())?;
        let rows = AllRows { store: &store, plan, output };
        let (columns, statistics) = rows.survey()?;
        let (mut summary, mut page) = (None, None);
        if store.count > 0 {
            let (finished, references) = (&store.shown()[..], &references.shown()[..]);
            let (statistics, claims, searches) = (&statistics, &verdicts[..], &found[..]);
            let shown = ShownResults { output, finished, statistics, references, claims, searches };
            let (of_summary, html) =
                pool.install(|| rayon::join(|| columns.write(output, &rows), || (self.page)(&shown)));
            summary = Some(of_summary?);
            // It names the summary. A link in the folder is replaced, not followed.
            let (path, html) = (output.join(names::REPORT), html?);
            atomic::write(&path, |out| out.write_all(html.as_bytes()).map_err(RecordError::io(&path)))?;
            page = Some(path);
        }
        let (unfinished, failed) = (store.unfinished, store.failed);
        let (finished, references) = (store.into_shown(), references.into_shown());
        Ok(Report {
            not_started,
            is_part: plan.is_part(),
            searches: found,
            search_files,
            not_needed,
            claims: verdicts,
            claims_file,
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
