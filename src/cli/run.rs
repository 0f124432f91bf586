//! `runner run`: simulate, judge, record.

use std::fmt::Write;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum, ValueHint};
use stiction::batch::{
    Batch, BatchFinished, BatchStarted, Junit, Listener, Message, Options, Progress, Report, Resumed, Severity, Teller,
    is_slow, simulate_before,
};
use stiction::remote::Pace;
use stiction::results::pareto::{Work, pareto_table};
use stiction::results::{Shown, SummaryRow, table, verdicts};
use stiction::text::visible::{visible, visible_path};

use super::each::Each;
use super::live::{Live, tell};
use super::machine::{Format, MessageFormat, TestResults};
use super::motor_server::pace;
use super::prepare::Scenarios;
use super::signals::{Asked, when_asked_to_end};
use super::terminal::{complain, complain_of, counted, plural, print};
use super::{Exit, numbers};

/// Runs whose files are named one by one below the table.
const MOST_NAMED: usize = 20;

/// Verdicts shown line by line when nothing is said about them; of more only those that did not hold.
const MOST_VERDICTS: usize = 2000;

/// Which verdicts are shown.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum Verdicts {
    /// Those that did not hold
    Failed,
    /// These, and all that name a value
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
    /// Runs side by side [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = numbers::count::<NonZero<usize>>, allow_negative_numbers = true)]
    jobs: Option<NonZero<usize>>,
    #[command(flatten)]
    each: Each,
    /// Start no more runs after the first that fails or does not finish
    #[arg(long, conflicts_with = "max_fail")]
    fail_fast: bool,
    /// Start no more runs once so many failed or did not finish
    #[arg(long, value_name = "N", value_parser = numbers::count::<NonZero<usize>>, allow_negative_numbers = true)]
    max_fail: Option<NonZero<usize>>,
    /// Make only the runs whose results are not in the folder, and say why those that are do not count
    #[arg(long)]
    resume: bool,
    /// Make all runs, whatever is in the folder: the default, for scripts that wish to say so
    #[arg(long, conflicts_with = "resume")]
    fresh: bool,
    /// Expectations to show, with measured value, wanted value and error [default: values, failed when there are too many]
    #[arg(long, value_name = "WHICH")]
    verdicts: Option<Verdicts>,
    #[command(flatten)]
    junit: TestResults,
    #[command(flatten)]
    format: Format,
    #[command(flatten)]
    live: Live,
    /// With --live: `free`, `realtime`, or a factor of it such as 0.5
    #[arg(long, value_name = "PACE", default_value = "free", value_parser = pace, requires = "live")]
    pace: Pace,
}

impl Run {
    /// Checks everything, runs everything, and shows what came of it.
    pub fn execute(self) -> Result<Exit, Exit> {
        let format = self.format.message_format;
        let mut last = BatchFinished::default();
        let done = self.batch(&mut last);
        last.exit_code = done.unwrap_or_else(|exit| exit) as u8;
        format.tell(Message::BatchFinished(last))?;
        done
    }

    /// Does all of this, and leaves what there is to tell of it at the end.
    fn batch(self, last: &mut BatchFinished) -> Result<Exit, Exit> {
        let format = self.format.message_format;
        let plan = self.scenarios.prepare(Severity::Note, format)?;
        let (runs, references) = (plan.runs(), plan.references());
        let pace = if let Pace::Times(times) = self.pace { Some(times) } else { None };
        let audience = self.live.start(&plan, pace).map_err(|error| refuse(&error, last, Exit::Invalid))?;
        let repetitions = if self.each.no_timing { 0 } else { plan.repetitions() };
        let options = Options {
            output: self.output.clone(),
            jobs: self.jobs.or(std::thread::available_parallelism().ok()).map_or(1, NonZero::get),
            log: !self.each.no_log,
            timeout: self.each.timeout,
            max_fail: if self.fail_fast { Some(NonZero::<usize>::MIN) } else { self.max_fail },
            slow: self.each.slow,
            problems: self.each.problems(),
            timing: !self.each.no_timing,
            resume: self.resume && !self.fresh,
        };
        let side_by_side = options.jobs.min(runs + references);
        let started = BatchStarted { jobs: side_by_side, ..BatchStarted::new(&plan, &options) };
        let mut junit = self.junit.listener(&plan, &options).map_err(|error| refuse(&error, last, Exit::Invalid))?;
        // Runs are made even if nobody can be told of them: a line that was not taken is an error of the last one.
        let mut teller = Teller::new(&options, |line| {
            let _ = print(&line);
        });
        let batch = Batch::new(plan, options).map_err(|error| refuse(&error, last, Exit::Invalid))?;
        if self.resume {
            resumed(batch.resumed());
        }
        let interrupter = batch.interrupter();
        let asked = when_asked_to_end(move |_| interrupter.interrupt());
        let then = match repetitions {
            0 => String::new(),
            n => format!(", then {} one at a time for timing", plural(n, "repetition")),
        };
        complain(&format!("{}, {side_by_side} side by side{then}", counted(runs, references)));
        let _ = format.tell(Message::BatchStarted(started));
        let mut listeners: Vec<&mut dyn Listener> = Vec::new();
        if format == MessageFormat::Json {
            listeners.push(&mut teller);
        }
        listeners.extend(junit.as_mut().map(|junit| junit as &mut dyn Listener));
        let report = batch.run_told(Progress::on_stderr(runs + references), &mut listeners, &|job, wanted, cancel| {
            simulate_before(job, wanted, cancel, audience.as_deref())
        });
        tell(audience.as_deref());
        // Also when the batch came to a bad end: what finished is known.
        let junit = junit.map(Junit::write);
        let report = report.map_err(|error| {
            if let Some(Err(error)) = &junit {
                refuse(error, last, Exit::Unfinished);
            }
            let exit = refuse(&error, last, Exit::Unfinished);
            let folder = self.output.display();
            complain(&format!(
                "runs that were finished are kept in {folder}, and runs.jsonl there has a line of each that could be told of; \
                 the same with --resume goes on from there"
            ));
            exit
        })?;
        // Test results that could not be written to the end leave the others as they are, and are told below them.
        let (junit, unwritten) = match junit {
            Some(Ok(path)) => (Some(path), None),
            Some(Err(error)) => (None, Some(error)),
            None => (None, None),
        };
        *last = BatchFinished::new(&report, junit.as_deref());
        if format == MessageFormat::Human {
            print(&summary(&report, self.verdicts, self.each.slow, junit.as_deref()))?;
        }
        match unwritten {
            Some(error) => Err(refuse(&error, last, Exit::Unfinished)),
            None => Ok(exit(&report, &asked)),
        }
    }
}

/// Tells what went wrong with the batch as a whole, now and in the last message.
fn refuse(error: &dyn std::error::Error, last: &mut BatchFinished, exit: Exit) -> Exit {
    complain_of(error);
    last.error = Some(error.to_string());
    exit
}

/// What is there already, and why other runs are made again.
fn resumed(resumed: &Resumed) {
    complain(&format!("resumed: {} done already", counted(resumed.runs(), resumed.references())));
    if resumed.other_builds() > 0 {
        let runs = plural(resumed.other_builds(), "run");
        complain(&format!(
            "  {runs} of these by another build of this version: what it computes may have changed since"
        ));
    }
    for again in resumed.again().iter().take(MOST_NAMED) {
        let example =
            if again.runs > 1 { format!(", such as {}", again.example) } else { format!(", {}", again.example) };
        complain(&format!("  {} again: {}{example}", plural(again.runs, "run"), again.why));
    }
    let more: usize = resumed.again().iter().skip(MOST_NAMED).map(|again| again.runs).sum();
    if more > 0 {
        complain(&format!("  {} again for other reasons", plural(more, "run")));
    }
    if resumed.first() > 0 {
        complain(&format!("  {} for the first time", plural(resumed.first(), "run")));
    }
}

/// The table, the verdicts and the paths written.
pub(super) fn summary(
    report: &Report,
    wanted: Option<Verdicts>,
    slow: Option<Duration>,
    junit: Option<&Path>,
) -> String {
    let all = report.rows();
    // Of more runs than can be kept those are shown that went wrong.
    let is_whole = report.statistics.runs() == all.len();
    let rows: Vec<_> = if is_whole { all } else { all.into_iter().filter(SummaryRow::is_refused).collect() };
    let mut out = if is_whole || !rows.is_empty() { table(&rows) } else { String::new() };
    if !is_whole {
        let outcomes = report.statistics.outcomes().into_iter().map(|(outcome, count)| format!("{count} {outcome}"));
        let words: Vec<String> = outcomes.collect();
        let (held, expected) = report.statistics.expectations();
        // A String takes every write.
        let _ = writeln!(out, "{}: {}", plural(report.statistics.runs(), "run"), words.join(", "));
        if expected > 0 {
            let _ = writeln!(out, "{held} of {expected} expectations held");
        }
    }
    let works: Vec<Work> = rows.iter().map(Work::of).collect();
    let accuracy = pareto_table(&works);
    if !accuracy.is_empty() {
        out += &format!("\n{accuracy}");
    }
    let judged = verdicts(&rows, shown(wanted, Shown::Values.count(&rows)));
    if !judged.is_empty() {
        out += &format!("\n{judged}");
    }
    if report.not_started > 0 {
        // A String takes every write.
        let _ = writeln!(out, "{} not started", plural(report.not_started, "run"));
    }
    for run in report.references.iter().chain(&report.finished).filter(|r| is_slow(slow, r.row.wall_s)) {
        let row = &run.row;
        let _ = writeln!(out, "slow: {} {} took {:.3} s", visible(&row.scenario), row.key, row.wall_s);
    }
    for run in report.references.iter().filter(|r| !r.accepted) {
        let (row, name) = (&run.row, run.row.outcome.name());
        let _ = writeln!(out, "{name} {} reference {}: {}", visible(&row.scenario), row.key, visible(&row.message));
    }
    for run in &report.finished {
        for note in &run.notes {
            let _ = writeln!(out, "{} {}: {}", visible(&run.row.scenario), run.row.key, visible(note));
        }
    }
    for reference in &report.references {
        for note in &reference.notes {
            let _ = writeln!(
                out,
                "{} reference {}: {}",
                visible(&reference.row.scenario),
                reference.row.key,
                visible(note)
            );
        }
    }
    let Some(files) = &report.summary else { return out };
    out += "\nwritten:\n";
    let own = [&files.csv, &files.parquet, &report.runs_log].into_iter().chain(&report.page).map(PathBuf::as_path);
    for path in own.chain(junit) {
        let _ = writeln!(out, "  {}", visible_path(path));
    }
    for file in report.references.iter().take(MOST_NAMED).flat_map(|f| &f.files) {
        let _ = writeln!(out, "  {}", visible_path(file));
    }
    for file in report.finished.iter().take(MOST_NAMED).flat_map(|f| &f.files) {
        let _ = writeln!(out, "  {}", visible_path(file));
    }
    if let more @ 1.. = report.statistics.runs().saturating_sub(MOST_NAMED) {
        let _ = writeln!(out, "  and the same for {}", plural(more, "more run"));
    }
    out
}

/// What was asked for; else all that name a value, unless there are too many of them.
fn shown(wanted: Option<Verdicts>, values: usize) -> Shown {
    match wanted {
        Some(Verdicts::Failed) => Shown::Failed,
        Some(Verdicts::Values) => Shown::Values,
        Some(Verdicts::All) => Shown::All,
        None if values > MOST_VERDICTS => Shown::Failed,
        None => Shown::Values,
    }
}

pub(super) fn exit(report: &Report, asked: &Asked) -> Exit {
    match () {
        () if report.interrupted => asked.exit(),
        () if report.has_unfinished() => Exit::Unfinished,
        () if report.has_failed() => Exit::Failed,
        () => Exit::Success,
    }
}
