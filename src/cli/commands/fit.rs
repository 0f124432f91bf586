//! `runner fit`: fits parameters of a scenario to recorded data.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use crate::batch::Severity;
use crate::fit::{self, Estimate, Fit, FitError};
use crate::text::visible::visible_path;
use clap::{Args, ValueEnum};

use crate::cli::Exit;
use crate::cli::arguments::numbers;
use crate::cli::exit::Ending;
use crate::cli::signals::on_termination_signal;
use crate::cli::terminal::{complain_of, print, show, width};

/// Arguments of `fit`.
#[derive(Args, Debug)]
pub struct FitCommand {
    /// The fit file: scenario, data, parameters and signals (docs/fitting.md)
    #[arg(value_name = "FIT")]
    file: PathBuf,
    /// Folder of fit.json, fitted.toml and fit.html [default: fits/NAME]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Parallel runs [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = numbers::count::<NonZero<usize>>, allow_negative_numbers = true)]
    jobs: Option<NonZero<usize>>,
    /// Format of the results on standard output
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Format of the results.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Format {
    /// Tables, for people
    Text,
    /// An object, as in fit.json
    Json,
}

impl FitCommand {
    /// Fits, writes the results and prints them.
    pub fn execute(self) -> Result<Exit, Exit> {
        let jobs = self.jobs.or(std::thread::available_parallelism().ok()).map_or(1, NonZero::get);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build().map_err(|error| {
            complain_of(format!("no threads: {error}"));
            Exit::Invalid
        })?;
        let fit = pool.install(|| Fit::load(&self.file)).map_err(|findings| {
            show(&findings, Severity::Note, usize::MAX);
            Exit::Invalid
        })?;
        let cancel = fit.cancel.clone();
        let first_signal = on_termination_signal(move |exit| {
            // A second signal ends a run that does not react.
            if cancel.swap(true, Ordering::Relaxed) {
                std::process::exit(exit as i32);
            }
        });
        let estimate = pool.install(|| fit.solve()).map_err(|error| {
            complain_of(&error);
            match error {
                FitError::Interrupted => first_signal.exit(),
                FitError::Run(_) => Exit::Unfinished,
            }
        })?;
        let folder = self.output.unwrap_or_else(|| Path::new("fits").join(fit.file.name()));
        let files = fit::write(&folder, &fit, &estimate).map_err(|error| {
            complain_of(&error);
            Exit::of_writing(&error)
        })?;
        print(&match self.format {
            Format::Text => {
                let written = [&files.json, &files.fitted, &files.page];
                let written: String = written.map(|path| format!("  {}\n", visible_path(path))).concat();
                format!("{}\nwritten:\n{written}", fit::summary(&estimate, width()))
            }
            Format::Json => match serde_json::to_string_pretty(&estimate) {
                Ok(text) => format!("{text}\n"),
                Err(error) => {
                    complain_of(error);
                    return Err(Exit::Unfinished);
                }
            },
        })?;
        Ok(exit_of(&estimate))
    }
}

fn exit_of(estimate: &Estimate) -> Exit {
    Exit::of_ending(Ending {
        interrupted: None,
        unfinished: estimate.is_unfinished(),
        failed: estimate.differs(),
        undecided: estimate.is_undetermined(),
    })
}
