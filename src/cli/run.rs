//! `runner run`: simulate, judge, record.

use std::fmt::Write;
use std::num::NonZero;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use stiction::batch::{Batch, Options, Progress, Report, Severity, simulate};
use stiction::record::pareto::{Work, pareto_table};
use stiction::record::{Shown, table, verdicts};
use stiction::sim::Problems;

use super::Exit;
use super::prepare::Scenarios;
use super::terminal::{complain, counted, plural, print};

/// Runs whose files are named one by one below the table.
const MOST_NAMED: usize = 20;

/// Verdicts shown line by line when nothing is said about them; of more only those that did not hold.
const MOST_VERDICTS: usize = 2000;

/// Which verdicts are shown.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Verdicts {
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
    #[arg(short, long, value_name = "DIR", default_value = "results")]
    output: PathBuf,
    /// Runs side by side [default: one per processor]
    #[arg(short, long, value_name = "N")]
    jobs: Option<NonZero<usize>>,
    /// Repeat no runs to time them
    #[arg(long)]
    no_timing: bool,
    /// Write no logs
    #[arg(long)]
    no_log: bool,
    /// Start no more runs after the first that fails or does not finish
    #[arg(long)]
    fail_fast: bool,
    /// Wall-clock limit of each run
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    timeout: Option<Duration>,
    /// Write contact problems as JSON: those without a valid state, or all; at most 100 of each run
    #[arg(long, value_name = "WHICH", num_args = 0..=1, require_equals = true, default_missing_value = "inconsistent")]
    dump_problems: Option<Which>,
    /// Expectations to show, with measured value, wanted value and error [default: values, failed when there are too many]
    #[arg(long, value_name = "WHICH")]
    verdicts: Option<Verdicts>,
}

/// Contact problems to write.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Which {
    /// Selections in which no state was valid
    Inconsistent,
    /// Every selection
    All,
}

/// A span of time above 0.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let number: f64 = text.parse().map_err(|_| "it is not a number".to_owned())?;
    match Duration::try_from_secs_f64(number) {
        Ok(duration) if !duration.is_zero() => Ok(duration),
        _ => Err("a number of seconds above 0 is wanted".into()),
    }
}

impl Run {
    /// Checks everything, runs everything, and shows what came of it.
    pub fn execute(self) -> Result<Exit, Exit> {
        let plan = self.scenarios.prepare(Severity::Note)?;
        let (runs, references) = (plan.jobs.len(), plan.references.len());
        let repetitions = if self.no_timing { 0 } else { plan.repetitions() };
        let options = Options {
            output: self.output.clone(),
            jobs: self.jobs.or(std::thread::available_parallelism().ok()).map_or(1, NonZero::get),
            log: !self.no_log,
            timeout: self.timeout,
            fail_fast: self.fail_fast,
            problems: match self.dump_problems {
                None => Problems::None,
                Some(Which::Inconsistent) => Problems::Inconsistent,
                Some(Which::All) => Problems::All,
            },
            timing: !self.no_timing,
        };
        let side_by_side = options.jobs.min(runs + references);
        let batch = Batch::new(plan, options).map_err(|error| {
            complain(&format!("error: {error}"));
            Exit::Invalid
        })?;
        let interrupter = batch.interrupter();
        if let Err(error) = ctrlc::set_handler(move || interrupter.interrupt()) {
            complain(&format!("warning: Ctrl-C will end the program at once: {error}"));
        }
        let then = match repetitions {
            0 => String::new(),
            n => format!(", then {} one at a time for timing", plural(n, "repetition")),
        };
        complain(&format!("{}, {side_by_side} side by side{then}", counted(runs, references)));
        let report = batch.run(Progress::on_stderr(runs + references), &simulate).map_err(|error| {
            complain(&format!("error: {error}"));
            Exit::Unfinished
        })?;
        print(&summary(&report, self.verdicts))?;
        Ok(exit(&report))
    }
}

/// The table, the verdicts and the paths written.
fn summary(report: &Report, wanted: Option<Verdicts>) -> String {
    let rows = report.rows();
    let mut out = table(&rows);
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
    for run in report.references.iter().filter(|r| !r.accepted) {
        let (row, name) = (&run.row, run.row.outcome.name());
        let _ = writeln!(out, "{name} {} reference {}: {}", row.scenario, row.key, row.message);
    }
    for run in &report.finished {
        for note in &run.notes {
            let _ = writeln!(out, "{} {}: {note}", run.row.scenario, run.row.key);
        }
    }
    for reference in &report.references {
        for note in &reference.notes {
            let _ = writeln!(out, "{} reference {}: {note}", reference.row.scenario, reference.row.key);
        }
    }
    let Some(files) = &report.summary else { return out };
    out += "\nwritten:\n";
    for path in [&files.csv, &files.parquet, &report.runs_log].into_iter().chain(&report.page) {
        let _ = writeln!(out, "  {}", path.display());
    }
    for file in report.references.iter().take(MOST_NAMED).flat_map(|f| &f.files) {
        let _ = writeln!(out, "  {}", file.display());
    }
    for file in report.finished.iter().take(MOST_NAMED).flat_map(|f| &f.files) {
        let _ = writeln!(out, "  {}", file.display());
    }
    if let more @ 1.. = report.finished.len().saturating_sub(MOST_NAMED) {
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

fn exit(report: &Report) -> Exit {
    match () {
        () if report.interrupted => Exit::Interrupted,
        () if report.has_unfinished() => Exit::Unfinished,
        () if report.has_failed() => Exit::Failed,
        () => Exit::Success,
    }
}
