//! `runner run`: simulates scenarios, evaluates and records them.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::batch::{
    Batch, BatchFinished, BatchStarted, Finished, Junit, Listener, Message, MessageWriter, Options, Progress, Report,
    Resumed, is_slow, marks_implausible, on_threads, simulate_with_clients,
};
use crate::files::make_durable;
use crate::remote::Pace;
use crate::report::batch_page;
use crate::results::claims::claim_table;
use crate::results::pareto::{Work, pareto_table};
use crate::results::searches::search_table;
use crate::results::{ListedVerdicts, SummaryRow, endings, overview, table, verdicts};
use crate::text::visible::{visible, visible_path};
use clap::{Args, ValueEnum, ValueHint};

use crate::cli::arguments::link::pace;
use crate::cli::arguments::live::{Live, print_notes};
use crate::cli::arguments::message_format::{Format, MessageFormat, TestResults};
use crate::cli::arguments::numbers;
use crate::cli::arguments::run_options::Each;
use crate::cli::arguments::selection::Scenarios;
use crate::cli::signals::on_termination_signal;
use crate::cli::terminal::{complain, complain_of, counted, plural, print};
use crate::cli::{Exit, terminal};

/// Maximum lines of one kind, such as notes, without `--verbose`.
const MOST_LINES: usize = 20;

/// Maximum notes about robots and scenarios without `--verbose`.
const MOST_NOTES: usize = 3;

/// Which verdicts a table shows.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum Verdicts {
    /// Only those that did not hold
    Failed,
    /// Failed ones, and all that name a value
    Values,
    /// All
    All,
}

/// Arguments of `run`.
#[derive(Args, Debug)]
pub struct Run {
    #[command(flatten)]
    scenarios: Scenarios,
    /// Folder of the results
    #[arg(short, long, value_name = "DIR", default_value = "results", value_hint = ValueHint::DirPath)]
    output: PathBuf,
    /// Parallel runs [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = numbers::count::<NonZero<usize>>, allow_negative_numbers = true)]
    jobs: Option<NonZero<usize>>,
    #[command(flatten)]
    each: Each,
    /// Start no further runs after the first that fails or does not finish
    #[arg(long, conflicts_with = "max_fail")]
    fail_fast: bool,
    /// Start no further runs after this many failed or did not finish
    #[arg(long, value_name = "N", value_parser = numbers::count::<NonZero<usize>>, allow_negative_numbers = true)]
    max_fail: Option<NonZero<usize>>,
    /// Run only what has no valid result in the folder, and report why other results are not valid
    #[arg(long)]
    resume: bool,
    /// Run everything again (the default; for scripts that state it explicitly)
    #[arg(long, conflicts_with = "resume")]
    fresh: bool,
    /// Show a table of expectations with measured value, expected value and error
    #[arg(long, value_name = "WHICH")]
    verdicts: Option<Verdicts>,
    /// Show a line per run, errors against cost, expected values, all notes and all files
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    junit: TestResults,
    #[command(flatten)]
    format: Format,
    #[command(flatten)]
    live: Live,
    /// With --live: `free`, `realtime` or a factor of real time such as 0.5
    #[arg(long, value_name = "PACE", default_value = "free", value_parser = pace, requires = "live")]
    pace: Pace,
}

impl Run {
    /// Checks and runs everything, and shows the results.
    pub fn execute(self) -> Result<Exit, Exit> {
        let format = self.format.message_format;
        let mut last = BatchFinished::default();
        let done = self.batch(&mut last);
        last.exit_code = done.unwrap_or_else(|exit| exit) as u8;
        format.emit(Message::BatchFinished(last))?;
        done
    }

    /// Runs the batch and fills in its last message.
    fn batch(self, last: &mut BatchFinished) -> Result<Exit, Exit> {
        let format = self.format.message_format;
        let notes = if self.verbose { usize::MAX } else { MOST_NOTES };
        let jobs = self.jobs.or(std::thread::available_parallelism().ok()).map_or(1, NonZero::get);
        let plan = on_threads(jobs, || self.scenarios.prepare(notes, format))
            .map_err(|error| refuse(&error, last, Exit::Unfinished))??;
        let (runs, references) = (plan.runs(), plan.references());
        let pace = if let Pace::Times(times) = self.pace { Some(times) } else { None };
        let clients = self.live.start(&plan, pace).map_err(|error| refuse(&error, last, Exit::Invalid))?;
        if self.each.durable {
            make_durable();
        }
        let repetitions = if self.each.no_timing { 0 } else { plan.repetitions() };
        let options = Options {
            output: self.output.clone(),
            jobs,
            log: !self.each.no_log,
            timeout: self.each.timeout,
            max_fail: if self.fail_fast { Some(NonZero::<usize>::MIN) } else { self.max_fail },
            slow: self.each.slow,
            problems: self.each.problems(),
            timing: !self.each.no_timing,
            resume: self.resume && !self.fresh,
        };
        let at_most = if plan.has_search() { "at most " } else { "" };
        let side_by_side = options.jobs.min(runs + references);
        let started = BatchStarted { jobs: side_by_side, ..BatchStarted::new(&plan, &options) };
        let mut junit = self.junit.listener(&plan, &options).map_err(|error| refuse(&error, last, Exit::Invalid))?;
        // Runs continue after a failed write; printing the last message then fails.
        let mut teller = MessageWriter::new(&options, |line| {
            let _ = print(&line);
        });
        let batch = Batch::new(plan, options, batch_page).map_err(|error| refuse(&error, last, Exit::Invalid))?;
        if self.resume {
            resumed(batch.resumed());
        }
        let interrupter = batch.interrupter();
        let first_signal = on_termination_signal(move |_| interrupter.interrupt());
        let then = match repetitions {
            0 => String::new(),
            n => format!(", then {} one at a time for timing", plural(n, "repetition")),
        };
        complain(&format!("{at_most}{}, {side_by_side} in parallel{then}", counted(runs, references)));
        let _ = format.emit(Message::BatchStarted(started));
        let mut listeners: Vec<&mut dyn Listener> = Vec::new();
        if format == MessageFormat::Json {
            listeners.push(&mut teller);
        }
        listeners.extend(junit.as_mut().map(|junit| junit as &mut dyn Listener));
        let report = batch.run_with_listener(
            Progress::on_stderr(runs + references, self.verbose),
            &mut listeners,
            &|job, outputs, cancel| simulate_with_clients(job, outputs, cancel, clients.as_deref()),
        );
        print_notes(clients.as_deref());
        // Written even if the batch failed: finished runs are known.
        let junit = junit.map(Junit::write);
        let report = report.map_err(|error| {
            if let Some(Err(error)) = &junit {
                refuse(error, last, Exit::Unfinished);
            }
            let exit = refuse(&error, last, Exit::Unfinished);
            let folder = self.output.display();
            complain(&format!(
                "finished runs remain in {folder}, and runs.jsonl lists those that could be recorded; repeat the command with \
                 --resume to continue"
            ));
            exit
        })?;
        // An error in writing test results is reported after the other results.
        let (junit, unwritten) = match junit {
            Some(Ok(path)) => (Some(path), None),
            Some(Err(error)) => (None, Some(error)),
            None => (None, None),
        };
        *last = BatchFinished::new(&report, junit.as_deref());
        if format == MessageFormat::Human {
            let (verdicts, verbose, slow) = (self.verdicts, self.verbose, self.each.slow);
            print(&summary(&report, Shows { verdicts, verbose, slow, junit: junit.as_deref() }))?;
        }
        match unwritten {
            Some(error) => Err(refuse(&error, last, Exit::Unfinished)),
            None => Ok(Exit::of_batch(&report, first_signal.exit())),
        }
    }
}

/// Reports an error of the whole batch, now and in the last message.
fn refuse(error: &dyn std::error::Error, last: &mut BatchFinished, exit: Exit) -> Exit {
    complain_of(error);
    last.error = Some(error.to_string());
    exit
}

/// Reports finished runs, and why others run again.
fn resumed(resumed: &Resumed) {
    complain(&format!("resumed: {} done already", counted(resumed.runs(), resumed.references())));
    if resumed.other_builds() > 0 {
        let runs = plural(resumed.other_builds(), "run");
        complain(&format!(
            "  {runs} of these by another build of this version: what it computes may have changed since"
        ));
    }
    for again in resumed.reruns().iter().take(MOST_LINES) {
        let example =
            if again.runs > 1 { format!(", such as {}", again.example) } else { format!(", {}", again.example) };
        complain(&format!("  {} again: {}{example}", plural(again.runs, "run"), again.why));
    }
    let more: usize = resumed.reruns().iter().skip(MOST_LINES).map(|again| again.runs).sum();
    if more > 0 {
        complain(&format!("  {} again for other reasons", plural(more, "run")));
    }
    if resumed.first() > 0 {
        complain(&format!("  {} for the first time", plural(resumed.first(), "run")));
    }
}

/// Contents of the summary on standard output.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shows<'a> {
    /// The table of verdicts; none: only those that failed, in the lines of their runs.
    pub verdicts: Option<Verdicts>,
    /// Everything, run by run.
    pub verbose: bool,
    /// Wall-clock time above which runs are named as slow.
    pub slow: Option<Duration>,
    /// File of the test results.
    pub junit: Option<&'a Path>,
}

/// One line per scenario, everything that failed, and where the results are.
pub(super) fn summary(report: &Report, shows: Shows) -> String {
    let width = terminal::width();
    let mut out = overview(&report.statistics, &marked(report), width);
    let rows: Vec<&SummaryRow> = report.finished.iter().map(|finished| &finished.row).collect();
    let part = |text: String| if text.is_empty() { text } else { format!("\n{text}") };
    if shows.verbose {
        // Where not all rows are in memory, the table shows failures.
        let is_whole = report.statistics.runs() == rows.len();
        let lines: Vec<_> = rows.iter().filter(|row| is_whole || row.is_refused()).map(|row| (*row).clone()).collect();
        out += &part(if lines.is_empty() { String::new() } else { table(&lines, width) });
        out += &part(pareto_table(&rows.iter().copied().map(Work::of).collect::<Vec<_>>(), width));
    }
    out += &part(endings(rows.iter().copied(), shows.verbose));
    if let Some(shown) = shown(shows) {
        out += &part(verdicts(rows.iter().copied(), shown, width));
    }
    out += &part(search_table(&report.searches, width));
    out += &part(claim_table(&report.claims, width));
    out += &remarks(report, shows);
    let Some(files) = &report.summary else { return out };
    out += "\nwritten:\n";
    let batch = [&files.csv, &files.parquet, &report.runs_log].into_iter().chain(&report.page);
    let batch = batch.chain(&report.search_files).chain(&report.claims_file).map(PathBuf::as_path);
    let runs = report.references.iter().chain(&report.finished).filter(|_| shows.verbose).flat_map(|f| &f.files);
    for path in batch.chain(shows.junit).chain(runs.map(PathBuf::as_path)) {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "  {}", visible_path(path));
    }
    if !shows.verbose {
        out += "-v shows each run, --verdicts values each expected value\n";
    }
    out
}

/// Scenarios with runs that are marked as implausible.
fn marked(report: &Report) -> BTreeSet<&str> {
    let marked = report.finished.iter().filter(|run| run.notes.iter().any(|note| marks_implausible(note)));
    marked.map(|run| run.row.scenario.as_str()).collect()
}

/// Runs that were not started, slow runs, reference runs that failed, and notes.
fn remarks(report: &Report, shows: Shows) -> String {
    let mut lines = Vec::new();
    if report.not_started > 0 {
        lines.push(format!("{} not started", plural(report.not_started, "run")));
    }
    if report.not_needed > 0 {
        lines.push(format!("{} not started, since their claims are decided", plural(report.not_needed, "run")));
    }
    for run in report.references.iter().chain(&report.finished).filter(|r| is_slow(shows.slow, r.row.wall_s)) {
        let row = &run.row;
        lines.push(format!("slow: {} {} took {:.3} s", visible(&row.scenario), row.key, row.wall_s));
    }
    for run in report.references.iter().filter(|r| !r.accepted) {
        let (row, name) = (&run.row, run.row.outcome.name());
        lines.push(format!("{name} {} reference {}: {}", visible(&row.scenario), row.key, visible(&row.message)));
    }
    let notes = |runs: &[Finished], role: &str| -> Vec<(bool, String)> {
        let of_run = |run: &Finished| {
            let name = format!("{}{role} {}", visible(&run.row.scenario), run.row.key);
            run.notes
                .iter()
                .map(move |note| (marks_implausible(note), format!("{name}: {}", visible(note))))
                .collect::<Vec<_>>()
        };
        runs.iter().flat_map(of_run).collect()
    };
    let mut notes = [notes(&report.finished, ""), notes(&report.references, " reference")].concat();
    // Marked runs come first, so that no other note hides them.
    notes.sort_by_key(|(is_mark, _)| !is_mark);
    let most = if shows.verbose { notes.len() } else { MOST_LINES };
    let more = notes.len().saturating_sub(most);
    lines.extend(notes.into_iter().take(most).map(|(_, line)| line));
    if more > 0 {
        lines.push(format!("and {}: see -v or the report", plural(more, "more note")));
    }
    lines.iter().map(|line| format!("{line}\n")).collect()
}

/// The verdicts in the table, if there is one.
fn shown(shows: Shows) -> Option<ListedVerdicts> {
    match shows.verdicts {
        Some(Verdicts::Failed) => Some(ListedVerdicts::Failed),
        Some(Verdicts::Values) => Some(ListedVerdicts::Values),
        Some(Verdicts::All) => Some(ListedVerdicts::All),
        None => shows.verbose.then_some(ListedVerdicts::Values),
    }
}
