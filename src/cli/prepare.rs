//! Selects, overrides, checks and expands scenarios for the commands that take them.

use std::num::NonZero;
use std::path::PathBuf;

use clap::{Args, ValueHint};
use stiction::batch::{self, DiagnosticMessage, Filter, Finding, Findings, Message, Plan, Severity, Shard};
use stiction::scenario::{DEFAULT_MAX_RUNS, Diagnostic, parse_override};

use super::machine::MessageFormat;
use super::{Exit, colour, inputs, numbers, terminal};

/// Default limit of expanded runs.
const MOST_RUNS: NonZero<usize> = NonZero::new(DEFAULT_MAX_RUNS).expect("it is above 0");

/// Scenarios, and which part of their runs.
#[derive(Args, Debug)]
pub struct Scenarios {
    #[command(flatten)]
    selection: Selection,
    /// Only part I of N equal parts, such as 3/8; `env` asks the job array of Slurm or Kubernetes that this is in
    #[arg(long, value_name = "I/N", value_parser = Asked::parse)]
    shard: Option<Asked>,
}

/// Scenarios and what is changed in all of them.
#[derive(Args, Debug)]
pub struct Selection {
    /// Scenario files; a folder means every .toml file in it
    #[arg(required = true, value_name = "SCENARIO", value_hint = ValueHint::AnyPath)]
    files: Vec<PathBuf>,
    /// Replace a value of every scenario, such as contact.method=one-step; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Override::parse)]
    overrides: Vec<Override>,
    /// Only runs of which this holds, such as 'name ~ "push*" and floor.friction.static < 0.5' (docs/ci.md)
    #[arg(long, value_name = "EXPR")]
    filter: Option<String>,
    /// Refuse to expand to more runs than this
    #[arg(long, value_name = "N", default_value_t = MOST_RUNS, value_parser = numbers::count::<NonZero<usize>>, allow_negative_numbers = true)]
    max_runs: NonZero<usize>,
    /// Take warnings for errors
    #[arg(long)]
    strict: bool,
}

/// Prints a diagnostic message if messages are enabled; returns the exit code.
fn tell(format: MessageFormat, severity: &'static str, words: &str, exit: Exit) -> Exit {
    let (message, rendered) = (words.to_owned(), format!("{severity}: {words}"));
    let told = DiagnosticMessage { severity, message, rendered, ..DiagnosticMessage::default() };
    format.tell(Message::Diagnostic(told)).err().unwrap_or(exit)
}

/// A value under its path, with the typed text.
#[derive(Clone, Debug)]
struct Override {
    typed: String,
    value: (String, toml::Value),
}

impl Override {
    fn parse(text: &str) -> Result<Self, String> {
        Ok(Override { typed: text.to_owned(), value: parse_override(text)? })
    }
}

/// A shard, and whether a Slurm job array selected it.
#[derive(Clone, Copy, Debug)]
struct Asked {
    shard: Shard,
    by_array: bool,
}

impl Asked {
    fn parse(text: &str) -> Result<Self, String> {
        let by_array = text == "env" && std::env::var_os("SLURM_ARRAY_TASK_ID").is_some();
        Ok(Asked { shard: text.parse()?, by_array })
    }
}

impl Scenarios {
    /// Loads, expands and checks everything; reports findings, at most `notes` notes of them.
    pub fn prepare(&self, notes: usize, format: MessageFormat) -> Result<Plan, Exit> {
        let mut plan = self.selection.prepare(notes, format)?;
        if let Some(Asked { shard, by_array }) = self.shard {
            let all = plan.runs();
            plan.take_shard(shard);
            terminal::complain(&format!("shard {shard}: {} of {all}", terminal::plural(plan.runs(), "run")));
            if by_array && shard.is_whole() {
                terminal::complain(
                    "warning: the job array has one task, which therefore has all runs; a task of a larger array is made \
                     again with `scontrol requeue JOB_TASK`, not with `sbatch --array=TASK`",
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
    terminal::complain_of(format!("one run is wanted, and this is {runs}: choose one with --filter or --set"));
    Err(Exit::Invalid)
}

impl Selection {
    /// Like [`Scenarios::prepare`], for all shards.
    pub fn prepare(&self, notes: usize, format: MessageFormat) -> Result<Plan, Exit> {
        let say = |findings: &Findings| {
            terminal::show(findings, Severity::Note, notes);
            format.tell_findings(findings)
        };
        let refused = |wrong: Box<Diagnostic>| {
            let mut findings = Findings::default();
            findings.push(Finding::Scenario(wrong));
            say(&findings).err().unwrap_or(Exit::Invalid)
        };
        let filter = self.filter.as_deref().map(Filter::parse).transpose().map_err(refused)?;
        let nothing = |words: String| {
            terminal::complain(&format!("nothing selected: {words}"));
            tell(format, "note", &format!("nothing selected: {words}"), Exit::Nothing)
        };
        let files = match inputs::scenario_files(&self.files) {
            Ok(files) => files,
            Err(inputs::Unusable::Nothing(words)) => return Err(nothing(words)),
            Err(inputs::Unusable::Wrong(all)) => {
                let told = all.into_iter().map(|words| {
                    terminal::complain_of(&words);
                    tell(format, "error", &words, Exit::Invalid)
                });
                return Err(told.fold(Exit::Invalid, |_, exit| exit));
            }
        };
        let overrides: Vec<_> = self.overrides.iter().map(|o| o.value.clone()).collect();
        let (mut plan, findings) = match batch::prepare(&files, &overrides, self.max_runs.get()) {
            Ok(prepared) => prepared,
            Err(findings) => {
                say(&findings)?;
                return Err(Exit::Invalid);
            }
        };
        say(&findings)?;
        if self.strict && findings.count(Severity::Warning) > 0 {
            let wrong = Finding::Plan("with --strict, warnings are errors".into());
            terminal::complain_drawn(&wrong.render(colour::on_stderr()));
            format.tell(Message::Diagnostic((&wrong).into()))?;
            return Err(Exit::Invalid);
        }
        if plan.runs() == 0 {
            return Err(nothing("the scenarios expand to no runs".into()));
        }
        if let Some(filter) = &filter {
            let all = plan.runs();
            plan.select(filter).map_err(refused)?;
            if plan.runs() == 0 {
                return Err(nothing(format!("the filter holds for none of {}", terminal::plural(all, "run"))));
            }
        }
        Ok(plan)
    }

    /// The selection as arguments for another machine, with absolute paths.
    pub fn words(&self) -> Result<Vec<String>, Exit> {
        let mut words: Vec<String> = self.overrides.iter().map(|o| format!("--set={}", o.typed)).collect();
        words.extend(self.filter.iter().map(|filter| format!("--filter={filter}")));
        if self.max_runs != MOST_RUNS {
            words.push(format!("--max-runs={}", self.max_runs));
        }
        if self.strict {
            words.push("--strict".into());
        }
        for file in &self.files {
            words.push(inputs::absolute_text(file)?);
        }
        Ok(words)
    }
}
