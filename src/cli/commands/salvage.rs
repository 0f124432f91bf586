//! `runner salvage`: recovers the readable part of damaged or unfinished logs.

use std::path::{Path, PathBuf};

use crate::log::{SalvageError, Salvaged, salvage};
use crate::results::unfinished_logs;
use crate::text::visible::visible_path;
use clap::{Args, ValueHint};

use crate::cli::Exit;
use crate::cli::terminal::{complain, complain_of, plural, print};

/// Arguments of `salvage`.
#[derive(Args, Debug)]
pub struct Salvage {
    /// Logs, or folders with unfinished logs of killed runs (.log.mcap.*.partial)
    #[arg(required = true, value_name = "LOG|FOLDER", value_hint = ValueHint::AnyPath)]
    logs: Vec<PathBuf>,
    /// File to write, for a single log [default: salvaged.mcap, or salvaged-*.mcap of an unfinished
    /// log, next to it]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Salvage {
    /// Writes what can be read of each log.
    pub fn execute(self) -> Result<Exit, Exit> {
        let mut logs = Vec::new();
        for path in &self.logs {
            match path.is_dir() {
                true => logs.extend(unfinished_logs(path).map_err(|error| {
                    complain_of(error);
                    Exit::Invalid
                })?),
                false => logs.push(path.clone()),
            }
        }
        if logs.is_empty() {
            complain("nothing to salvage: no unfinished logs");
            return Ok(Exit::Nothing);
        }
        if self.output.is_some() && logs.len() > 1 {
            complain_of(format!("--output names the file of one log, found {}", plural(logs.len(), "log")));
            return Err(Exit::Invalid);
        }
        let mut exit = Exit::Success;
        for log in logs {
            let to = self.output.clone().unwrap_or_else(|| salvaged_path(&log));
            match salvage(&log, &to) {
                Ok(salvaged) => print(&describe(&to, &salvaged))?,
                Err(error) => {
                    complain_of(&error);
                    exit = match &error {
                        SalvageError::Write(error) => Exit::of_writing(error),
                        SalvageError::Read(_) => Exit::Invalid,
                    };
                }
            }
        }
        Ok(exit)
    }
}

/// `salvaged.mcap` next to a log; of `.log.mcap.NAME.partial`, `salvaged-NAME.mcap`.
fn salvaged_path(log: &Path) -> PathBuf {
    let name = log.file_name().unwrap_or_default().to_string_lossy();
    let unfinished = name.strip_prefix(".log.mcap.").and_then(|rest| rest.strip_suffix(".partial"));
    let name = unfinished.map_or("salvaged.mcap".to_owned(), |unique| format!("salvaged-{unique}.mcap"));
    log.with_file_name(name)
}

fn describe(to: &Path, salvaged: &Salvaged) -> String {
    let Salvaged { messages, until_s, damaged_chunks, damaged_records, incomplete, unread_bytes, whole } = *salvaged;
    let mut omitted = Vec::new();
    if damaged_chunks > 0 {
        omitted.push(plural(damaged_chunks, "damaged chunk"));
    }
    if damaged_records > 0 {
        omitted.push(plural(damaged_records, "damaged record"));
    }
    if incomplete > 0 {
        omitted.push(format!("{} of incomplete ticks", plural(incomplete, "message")));
    }
    if unread_bytes > 0 {
        omitted.push(format!("{} at the end", plural(unread_bytes, "byte")));
    }
    let omitted = match omitted.is_empty() {
        _ if whole => "; nothing is missing".to_owned(),
        true => "; the log does not match its checksums".to_owned(),
        false => format!("; left out: {}", omitted.join(", ")),
    };
    format!("{}: {} up to {until_s} s{omitted}\n", visible_path(to), plural(messages, "message"))
}
