//! `runner replay`: repeats runs from their records and compares them bit for bit.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use clap::Args;
use stiction::batch::{BatchError, Interrupter, Severity};
use stiction::replay::{self, InputChange, RecordedRun, ReplayError};
use stiction::text::visible::visible;

use super::each::Which;
use super::signals::when_asked_to_end;
use super::terminal::{complain, complain_of, plural, print, show};
use super::{Exit, numbers};

/// Arguments of `replay`.
#[derive(Args, Debug)]
pub struct Replay {
    /// The key of a run or its beginning, the folder of a run, or a folder of results for all runs in it
    #[arg(required = true, value_name = "KEY|FOLDER")]
    what: Vec<String>,
    /// Where runs are looked for by their keys
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Folder at which relative paths of the scenario begin [default: that of the scenario file, as the record has it]
    #[arg(long, value_name = "DIR")]
    base: Option<PathBuf>,
    /// Keep what the runs leave this time in this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Write contact problems as JSON beside what is kept: those without a valid state, or all; at most 100 of each run
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
        for what in &self.what {
            all.extend(replay::find(what, &self.results).map_err(refuse)?);
        }
        if all.is_empty() {
            complain("nothing selected: there are no runs in these folders");
            return Err(Exit::Nothing);
        }
        let running: Arc<Mutex<Option<Interrupter>>> = Arc::default();
        let interrupted = running.clone();
        let asked = when_asked_to_end(move |exit| stop(&interrupted, exit));
        let (mut same, mut differ, mut unknown) = (0, 0, Vec::new());
        for left in &all {
            match self.is_same(left, &running) {
                Ok(true) => same += 1,
                Ok(false) => differ += 1,
                Err(Exit::Interrupted) => return Err(asked.exit()),
                // Continue with the other runs.
                Err(exit) => unknown.push(exit),
            }
        }
        if all.len() > 1 {
            let lost = if unknown.is_empty() {
                String::new()
            } else {
                format!(", {} not made again", plural(unknown.len(), "run"))
            };
            print(&format!("{} gave the same bits, {differ} did not{lost}\n", plural(same, "run")))?;
        }
        let worst = unknown.into_iter().max_by_key(|exit| *exit as u8);
        Ok(worst.unwrap_or(if differ == 0 { Exit::Success } else { Exit::Failed }))
    }

    /// Repeats one run; true if nothing differs.
    fn is_same(&self, left: &RecordedRun, running: &Mutex<Option<Interrupter>>) -> Result<bool, Exit> {
        let temporary = tempfile::tempdir().map_err(|error| refuse(format!("no temporary folder: {error}")))?;
        let output: &Path = self.output.as_deref().unwrap_or(temporary.path());
        let prepared =
            replay::prepare(left, self.base.as_deref(), output, self.timeout, Which::problems(self.dump_problems))
                .map_err(refuse)?;
        if same_file(&left.path, prepared.path()) {
            return Err(refuse(format!("{} would be written over: choose another folder", left.path.display())));
        }
        if let Ok(mut slot) = running.lock() {
            *slot = Some(prepared.interrupter());
        }
        let again = prepared.run(left).map_err(refuse)?;
        let name = format!("{} {}", visible(&left.record.scenario), left.record.key);
        again.changes.iter().for_each(|change| complain(&format!("warning: {name}: {change}")));
        if again.run.terminated_externally() && !left.terminated_externally() {
            let at = again.run.record.metrics.duration_s;
            complain_of(format!("{name}: not finished within --timeout, it stands at {at} s: nothing is compared"));
            return Err(Exit::Unfinished);
        }
        let differences = replay::compare(left, &again);
        let files = if left.log.is_some() { "run.json and log.mcap" } else { "run.json; it left no log" };
        let words = match differences.as_slice() {
            [] if left.terminated_externally() && left.log.is_none() => {
                format!("{name}: it was ended from outside and left no log: there is nothing to compare\n")
            }
            [] if left.terminated_externally() => {
                format!("{name}: same bits up to where it was ended from outside (log.mcap)\n")
            }
            [] if !again.changes.iter().any(InputChange::affects_result) => format!("{name}: same bits ({files})\n"),
            [] => format!("{name}: same values, though not all is as it was ({files})\n"),
            all => all.iter().fold(format!("{name}: differs\n"), |text, one| format!("{text}  {one}\n")),
        };
        print(&words)?;
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
        Refusal::Words(words) => {
            complain_of(words);
            Exit::Invalid
        }
    }
}

enum Refusal {
    Replay(ReplayError),
    Words(String),
}

impl From<ReplayError> for Refusal {
    fn from(error: ReplayError) -> Self {
        Refusal::Replay(error)
    }
}

impl From<String> for Refusal {
    fn from(words: String) -> Self {
        Refusal::Words(words)
    }
}
