//! `runner replay`: repeats runs from their records and compares them bit for bit.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::batch::{BatchError, Interrupter, Severity};
use crate::replay::{self, InputChange, RecordedRun, ReplayError};
use crate::text::visible::{visible, visible_lines};
use clap::Args;

use crate::cli::Exit;
use crate::cli::arguments::numbers;
use crate::cli::arguments::run_options::Which;
use crate::cli::signals::on_termination_signal;
use crate::cli::terminal::{complain, complain_of, plural, print, show};

/// Arguments of `replay`.
#[derive(Args, Debug)]
pub struct Replay {
    /// The key of a run or its beginning, the folder of a run, or a folder of results for all runs
    /// in it
    #[arg(required = true, value_name = "KEY|FOLDER")]
    what: Vec<String>,
    /// Folder in which runs are found by their keys
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder of the scenario's relative paths [default: that of the recorded scenario file]
    #[arg(long, value_name = "DIR")]
    base: Option<PathBuf>,
    /// Write the results of the re-runs to this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write contact problems as JSON with the results: those without a valid state, or all; at
    /// most 100 per run
    #[arg(long, value_name = "WHICH", num_args = 0..=1, require_equals = true, default_missing_value = "inconsistent")]
    #[arg(requires = "output")]
    dump_problems: Option<Which>,
    /// Wall-clock limit of each run
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_negative_numbers = true)]
    timeout: Option<Duration>,
}

impl Replay {
    /// Repeats each run and reports the comparison.
    pub fn execute(self) -> Result<Exit, Exit> {
        let mut all: Vec<RecordedRun> = Vec::new();
        let mut unknown = Vec::new();
        for what in &self.what {
            let (found, skipped) = replay::find(what, &self.results).map_err(refuse)?;
            all.extend(found);
            unknown.extend(skipped.iter().map(|error| refuse(format!("not re-run: {error}"))));
        }
        let chosen = all.len() + unknown.len();
        if chosen == 0 {
            complain("nothing selected: there are no runs in these folders");
            return Err(Exit::Nothing);
        }
        let running: Arc<Mutex<Option<Interrupter>>> = Arc::default();
        let interrupted = running.clone();
        let first_signal = on_termination_signal(move |exit| stop(&interrupted, exit));
        let (mut same, mut differ) = (0, 0);
        for recorded in &all {
            match self.is_same(recorded, &running) {
                Ok(true) => same += 1,
                Ok(false) => differ += 1,
                Err(Exit::Interrupted) => return Err(first_signal.exit()),
                // Continue with the other runs.
                Err(exit) => unknown.push(exit),
            }
        }
        if chosen > 1 {
            let lost = if unknown.is_empty() {
                String::new()
            } else {
                format!(", {} not re-run", plural(unknown.len(), "run"))
            };
            print(&format!("{} gave the same bits, {differ} did not{lost}\n", plural(same, "run")))?;
        }
        let worst = unknown.into_iter().max_by_key(|exit| *exit as u8);
        Ok(worst.unwrap_or(if differ == 0 { Exit::Success } else { Exit::Failed }))
    }

    /// Repeats one run; true if nothing differs.
    fn is_same(&self, recorded: &RecordedRun, running: &Mutex<Option<Interrupter>>) -> Result<bool, Exit> {
        let temporary = tempfile::tempdir().map_err(|error| refuse(format!("no temporary folder: {error}")))?;
        let output: &Path = self.output.as_deref().unwrap_or(temporary.path());
        let prepared =
            replay::prepare(recorded, self.base.as_deref(), output, self.timeout, Which::problems(self.dump_problems))
                .map_err(refuse)?;
        if same_file(&recorded.path, prepared.path()) {
            return Err(refuse(format!("{} would be written over: choose another folder", recorded.path.display())));
        }
        if let Ok(mut slot) = running.lock() {
            *slot = Some(prepared.interrupter());
        }
        let again = prepared.run(recorded).map_err(refuse)?;
        let name = format!("{} {}", visible(&recorded.record.scenario), recorded.record.key);
        again.changes.iter().for_each(|change| complain(&format!("warning: {name}: {change}")));
        if again.run.terminated_externally() && !recorded.terminated_externally() {
            let at = again.run.record.metrics.duration_s;
            complain_of(format!("{name}: not finished within --timeout, stopped at {at} s: not compared"));
            return Err(Exit::Unfinished);
        }
        let differences = replay::compare(recorded, &again);
        if !differences.is_empty() && recorded.has_changed() {
            return Err(refuse(format!("{}: changed while it was re-run: not compared", recorded.path.display())));
        }
        let files = if recorded.log.is_some() { "run.json and log.mcap" } else { "run.json; there is no log" };
        let text = match differences.as_slice() {
            [] if recorded.terminated_externally() && recorded.log.is_none() => {
                format!("{name}: terminated externally and without a log: nothing to compare\n")
            }
            [] if recorded.terminated_externally() => {
                format!("{name}: same bits up to the external termination (log.mcap)\n")
            }
            [] if !again.changes.iter().any(InputChange::affects_result) => format!("{name}: same bits ({files})\n"),
            [] => format!("{name}: same values despite the changes ({files})\n"),
            all => all.iter().fold(format!("{name}: differs\n"), |lines, one| format!("{lines}  {one}\n")),
        };
        print(&visible_lines(&text))?;
        Ok(differences.is_empty())
    }
}

/// Cancels the active run, whose output would be useless.
fn stop(running: &Mutex<Option<Interrupter>>, exit: Exit) {
    let slot = running.lock().ok().and_then(|slot| slot.clone());
    match slot {
        Some(interrupter) => (0..2).for_each(|_| interrupter.interrupt()),
        None => std::process::exit(exit as i32),
    }
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

fn refuse(why: impl Into<Refusal>) -> Exit {
    match why.into() {
        Refusal::Replay(ReplayError::Interrupted) => {
            complain("interrupted");
            Exit::Interrupted
        }
        Refusal::Replay(error) => {
            if let ReplayError::Invalid { findings, .. } = &error {
                show(findings, Severity::Error, 0);
            }
            complain_of(&error);
            // Folder and threads are checked before anything runs; later errors come from the disk.
            match &error {
                ReplayError::Batch(BatchError::Record(cause)) => Exit::of_writing(cause),
                _ => Exit::Invalid,
            }
        }
        Refusal::Text(text) => {
            complain_of(text);
            Exit::Invalid
        }
    }
}

enum Refusal {
    Replay(ReplayError),
    Text(String),
}

impl From<ReplayError> for Refusal {
    fn from(error: ReplayError) -> Self {
        Refusal::Replay(error)
    }
}

impl From<String> for Refusal {
    fn from(text: String) -> Self {
        Refusal::Text(text)
    }
}
