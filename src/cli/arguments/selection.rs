//! Selects, overrides, checks and expands scenarios for the commands that take them.

use std::num::NonZero;
use std::path::PathBuf;
use std::time::Duration;

use crate::batch::{
    self, DiagnosticMessage, Filter, Finding, Findings, Message, Part, Plan, Severity, Shard, ShardError,
};
use crate::scenario::{DEFAULT_MAX_RUNS, Diagnostic, OverrideError, parse_override};
use clap::{Args, ValueHint};

use crate::cli::arguments::message_format::MessageFormat;
use crate::cli::arguments::numbers;
use crate::cli::arguments::override_files;
use crate::cli::arguments::scenario_files;
use crate::cli::{Exit, colour, terminal};

/// Default limit of expanded runs.
const MOST_RUNS: NonZero<usize> = NonZero::new(DEFAULT_MAX_RUNS).expect("it is above 0");

/// Scenarios, and the part of their runs to execute.
#[derive(Args, Debug)]
pub struct Scenarios {
    #[command(flatten)]
    selection: Selection,
    /// Run only part I of N equal parts, such as 3/8; `env` takes both from the job array of Slurm
    /// or Kubernetes
    #[arg(long, value_name = "I/N", value_parser = ShardArgument::parse)]
    shard: Option<ShardArgument>,
}

/// Scenarios and the values replaced in all of them.
#[derive(Args, Debug)]
pub struct Selection {
    /// Scenario files; a folder means every .toml file in it
    #[arg(required = true, value_name = "SCENARIO", value_hint = ValueHint::AnyPath)]
    files: Vec<PathBuf>,
    /// Replace a value of every scenario, such as contact.method=one-step; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Override::parse)]
    overrides: Vec<Override>,
    /// Replace values by those of a TOML file of keys and values, such as fitted.toml of `fit`; --set
    /// comes after them; may be repeated
    #[arg(long = "set-from", value_name = "FILE", value_hint = ValueHint::FilePath)]
    override_files: Vec<PathBuf>,
    /// Select runs by a condition, such as 'name ~ "push*" and floor.friction.static < 0.5'
    /// (docs/ci.md)
    #[arg(long, value_name = "EXPR")]
    filter: Option<String>,
    /// Refuse to expand to more runs than this
    #[arg(long, value_name = "N", default_value_t = MOST_RUNS, value_parser = numbers::count::<NonZero<usize>>, allow_negative_numbers = true)]
    max_runs: NonZero<usize>,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

/// Prints a diagnostic message if messages are enabled; returns the exit code.
fn emit(format: MessageFormat, severity: &'static str, text: &str, exit: Exit) -> Exit {
    let (message, rendered) = (text.to_owned(), format!("{severity}: {text}"));
    let diagnostic = DiagnosticMessage { severity, message, rendered, ..DiagnosticMessage::default() };
    format.emit(Message::Diagnostic(diagnostic)).err().unwrap_or(exit)
}

/// A value under its path, with the typed text.
#[derive(Clone, Debug)]
struct Override {
    typed: String,
    value: (String, toml::Value),
}

impl Override {
    fn parse(text: &str) -> Result<Self, OverrideError> {
        Ok(Override { typed: text.to_owned(), value: parse_override(text)? })
    }
}

/// A shard, and whether a Slurm job array selected it.
#[derive(Clone, Copy, Debug)]
struct ShardArgument {
    shard: Shard,
    by_array: bool,
}

impl ShardArgument {
    fn parse(text: &str) -> Result<Self, ShardError> {
        let by_array = text == "env" && std::env::var_os("SLURM_ARRAY_TASK_ID").is_some();
        Ok(ShardArgument { shard: text.parse()?, by_array })
    }
}

impl Scenarios {
    /// Loads, expands and checks everything; reports findings, at most `notes` notes of them.
    pub fn prepare(&self, notes: usize, format: MessageFormat) -> Result<Plan, Exit> {
        self.prepare_within(notes, format, batch::DEFAULT_TIME_LIMIT)
    }

    /// Like [`Scenarios::prepare`], with a wall-clock limit for the scripts of each run.
    pub fn prepare_within(&self, notes: usize, format: MessageFormat, time_limit: Duration) -> Result<Plan, Exit> {
        let shard = self.shard.map(|argument| argument.shard);
        let plan = self.selection.prepare_within(notes, format, time_limit, shard)?;
        if let Some(ShardArgument { shard, by_array }) = self.shard {
            let all = plan.part.as_ref().map_or(plan.runs(), Part::total);
            terminal::complain(&format!("shard {shard}: {} of {all}", terminal::plural(plan.runs(), "run")));
            if by_array && shard.is_whole() {
                terminal::complain(
                    "warning: the job array has one task, which therefore has all runs; a task of a larger array is re-run \
                     with `scontrol requeue JOB_TASK`, not with `sbatch --array=TASK`",
                );
            }
        }
        Ok(plan)
    }
}

/// Refuses a plan of more than one run.
pub fn only(plan: &Plan) -> Result<(), Exit> {
    if plan.runs() == 1 {
        return Ok(());
    }
    let runs = terminal::counted(plan.runs(), plan.references());
    terminal::complain_of(format!("expected one run, found {runs}: select one with --filter or --set"));
    Err(Exit::Invalid)
}

impl Selection {
    /// Like [`Scenarios::prepare`], for all shards.
    pub fn prepare(&self, notes: usize, format: MessageFormat) -> Result<Plan, Exit> {
        self.prepare_within(notes, format, batch::DEFAULT_TIME_LIMIT, None)
    }

    fn prepare_within(
        &self,
        notes: usize,
        format: MessageFormat,
        time_limit: Duration,
        shard: Option<Shard>,
    ) -> Result<Plan, Exit> {
        let report = |findings: &Findings| {
            terminal::show(findings, Severity::Note, notes);
            format.emit_findings(findings)
        };
        let refused = |wrong: Box<Diagnostic>| {
            let mut findings = Findings::default();
            findings.push(Finding::Scenario(wrong));
            report(&findings).err().unwrap_or(Exit::Invalid)
        };
        let filter = self.filter.as_deref().map(Filter::parse).transpose().map_err(refused)?;
        let nothing = |reason: String| {
            terminal::complain(&format!("nothing selected: {reason}"));
            emit(format, "note", &format!("nothing selected: {reason}"), Exit::Nothing)
        };
        let files = match scenario_files::scenario_files(&self.files) {
            Ok(files) => files,
            Err(scenario_files::Unusable::Nothing(reason)) => return Err(nothing(reason)),
            Err(scenario_files::Unusable::Wrong(all)) => {
                let exits = all.into_iter().map(|text| {
                    terminal::complain_of(&text);
                    emit(format, "error", &text, Exit::Invalid)
                });
                return Err(exits.fold(Exit::Invalid, |_, exit| exit));
            }
        };
        let overrides = self.all_overrides().map_err(refused)?;
        // A filter is judged by all runs.
        let planned = shard.filter(|_| filter.is_none());
        let prepared = batch::prepare_within(&files, &overrides, self.max_runs.get(), time_limit, planned);
        let (mut plan, findings) = match prepared {
            Ok(prepared) => prepared,
            Err(findings) => {
                report(&findings)?;
                return Err(Exit::Invalid);
            }
        };
        report(&findings)?;
        if self.strict && findings.count(Severity::Warning) > 0 {
            let wrong = Finding::Plan("with --strict, warnings are errors".into());
            terminal::complain_drawn(&wrong.render(colour::on_stderr()));
            format.emit(Message::Diagnostic((&wrong).into()))?;
            return Err(Exit::Invalid);
        }
        if plan.part.as_ref().map_or(plan.runs(), Part::total) == 0 {
            return Err(nothing("the scenarios expand to no runs".into()));
        }
        if let Some(filter) = &filter {
            let all = plan.runs();
            plan.select(filter).map_err(refused)?;
            if plan.runs() == 0 {
                return Err(nothing(format!("the filter holds for none of {}", terminal::plural(all, "run"))));
            }
        }
        if let Some(shard) = shard.filter(|_| plan.part.is_none()) {
            plan.take_shard(shard);
        }
        Ok(plan)
    }

    /// The values of files, then those of the command line.
    fn all_overrides(&self) -> Result<Vec<(String, toml::Value)>, Box<Diagnostic>> {
        let mut all = Vec::new();
        for file in &self.override_files {
            all.extend(override_files::read(file)?);
        }
        all.extend(self.overrides.iter().map(|o| o.value.clone()));
        Ok(all)
    }

    /// The selection as arguments for another machine, with absolute paths.
    pub fn to_arguments(&self) -> Result<Vec<String>, Exit> {
        let files = self.override_files.iter();
        let files = files.map(|file| Ok(format!("--set-from={}", scenario_files::absolute_text(file)?)));
        let mut arguments: Vec<String> = files.collect::<Result<_, Exit>>()?;
        arguments.extend(self.overrides.iter().map(|o| format!("--set={}", o.typed)));
        arguments.extend(self.filter.iter().map(|filter| format!("--filter={filter}")));
        if self.max_runs != MOST_RUNS {
            arguments.push(format!("--max-runs={}", self.max_runs));
        }
        if self.strict {
            arguments.push("--strict".into());
        }
        for file in &self.files {
            arguments.push(scenario_files::absolute_text(file)?);
        }
        Ok(arguments)
    }
}
