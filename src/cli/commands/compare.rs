//! `runner compare`: lists differences between two results, or of many from a baseline, and appends them to a
//! history.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use crate::compare::{Limits, Results, Tolerance, compare};
use crate::files::names;
use crate::history::{AppendError, Baseline, Compared, KEPT_RESULTS, TrendRule, append};
use crate::results::claims::Judgement;
use clap::{Args, ValueEnum};
use serde::Serialize;

use crate::cli::Exit;
use crate::cli::arguments::numbers::{self, NumberError};
use crate::cli::terminal::{complain, complain_of, print};

/// Greatest number of values of a series that `--last` takes.
const MOST_VALUES: u64 = 200;

/// Arguments of `compare`.
#[derive(Args, Debug)]
#[command(override_usage = "runner compare [OPTIONS] A B\n       runner compare [OPTIONS] --baseline BASE RESULTS...")]
pub struct Compare {
    /// Results: a folder, summary.csv, summary.parquet or runs.jsonl. Two of them, A and B, from different versions,
    /// machines or dates; with --baseline any number
    #[arg(value_name = "RESULTS", required = true)]
    results: Vec<PathBuf>,
    /// Compare all RESULTS with this: results, or a history, to which --append adds. A folder stands for its results,
    /// or for the history.parquet in it
    #[arg(long, value_name = "BASE")]
    baseline: Option<PathBuf>,
    /// After the comparison, append RESULTS to the history BASE: a .parquet file, or history.parquet in a folder. It is
    /// created if it is missing
    #[arg(long, requires = "baseline")]
    append: bool,
    /// Name of the results in the history, such as a version or commit
    #[arg(long, value_name = "TEXT", requires = "append")]
    label: Option<String>,
    /// Number of results that the history keeps: the newest ones
    #[arg(long, value_name = "N", default_value_t = KEPT_RESULTS, value_parser = numbers::count::<NonZeroUsize>, requires = "append")]
    keep: NonZeroUsize,
    /// Number of values of each run and metric in the history that statistics and trends take: the newest ones, at most 200
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=MOST_VALUES), requires = "baseline")]
    last: u64,
    /// Greatest probability of reporting a trend where there is none, in all series of a result together
    #[arg(long, value_name = "LEVEL", default_value = "0.01", value_parser = numbers::level, requires = "baseline")]
    trend: f64,
    /// Allowed difference in columns that --threshold does not name, in their units
    #[arg(long, value_name = "ABS", default_value = "1e-9", value_parser = numbers::allowed, allow_negative_numbers = true)]
    absolute: f64,
    /// Allowed difference relative to the greater value; added to --absolute
    #[arg(long, value_name = "REL", default_value = "1e-6", value_parser = numbers::allowed, allow_negative_numbers = true)]
    relative: f64,
    /// Allowed difference in one column, and relative to the greater value [default: 0]; `inf`
    /// ignores the column; may be repeated
    #[arg(long = "threshold", value_name = "COLUMN=ABS[,REL]", value_parser = threshold)]
    thresholds: Vec<(String, Tolerance)>,
    /// Compare times too: B may take up to this many times as long as A. In histories also trends of times
    #[arg(long, value_name = "RATIO", value_parser = numbers::ratio, allow_negative_numbers = true)]
    timing: Option<f64>,
    /// Format of the differences
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Format of the differences.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Format {
    /// Tables, for people
    Text,
    /// An object
    Json,
}

impl Compare {
    /// Prints the differences.
    pub fn execute(self) -> Result<Exit, Exit> {
        let limits = Limits {
            default: Tolerance { absolute: self.absolute, relative: self.relative },
            columns: self.thresholds.iter().cloned().collect::<BTreeMap<_, _>>(),
            timing: self.timing,
        };
        let [a, b] = match (&self.baseline, self.results.as_slice()) {
            (Some(baseline), _) => return self.with_baseline(baseline, &limits),
            (None, [a, b]) => [a, b],
            (None, _) => {
                complain_of("two results are required, A and B, or --baseline BASE with any number");
                return Err(Exit::Invalid);
            }
        };
        let [a, b] = [a, b].map(|path| Results::open(path).map_err(refused));
        let (mut a, mut b) = (a?, b?);
        if a.is_empty() && b.is_empty() {
            return Err(nothing(&a.path, &b.path));
        }
        let changes = compare(&mut a, &mut b, &limits).map_err(refused)?;
        print(&match self.format {
            Format::Text => format!("A: {}\nB: {}\n{changes}", a.path.display(), b.path.display()),
            Format::Json => json(&changes)?,
        })?;
        Ok(if changes.is_within() { Exit::Success } else { Exit::Failed })
    }

    /// Compares all results with a baseline, then appends them to it.
    fn with_baseline(&self, base: &Path, limits: &Limits) -> Result<Exit, Exit> {
        let is_folder = base.is_dir() || !base.exists() && base.extension().is_none_or(|own| own != "parquet");
        let base = if self.append && is_folder { base.join(names::HISTORY) } else { base.to_owned() };
        let opened = if self.append { Baseline::open_history(&base) } else { Baseline::open(&base) };
        let mut baseline = opened.map_err(refused)?;
        let opened = self.results.iter().map(|path| Results::open(path).map_err(refused));
        let mut all = opened.collect::<Result<Vec<_>, _>>()?;
        if let Some(first) = all.first().filter(|_| baseline.is_empty() && all.iter().all(Results::is_empty)) {
            return Err(nothing(baseline.path(), &first.path));
        }
        let rule = TrendRule { last: self.last as usize, level: self.trend };
        let mut compared = Vec::new();
        for results in &mut all {
            compared.push(baseline.compare(results, limits, rule).map_err(refused)?);
        }
        // All were compared with the same history. What was compared is printed also if it cannot be written.
        let mut unwritten = None;
        if self.append {
            let label = self.label.as_deref().map(str::trim).filter(|label| !label.is_empty());
            for (results, compared) in all.iter_mut().zip(&mut compared) {
                match append(&base, results, label, self.keep.get()) {
                    Ok(appended) => compared.appended = Some(appended),
                    Err(error) => {
                        complain_of(&error);
                        unwritten = Some(match error {
                            AppendError::History(_) => Exit::Invalid,
                            AppendError::Write(error) => Exit::of_writing(&error),
                        });
                        break;
                    }
                }
            }
        }
        let compared = Compared::new(baseline.path(), compared);
        print(&match self.format {
            Format::Text => compared.to_string(),
            Format::Json => json(&compared)?,
        })?;
        if let Some(exit) = unwritten {
            return Err(exit);
        }
        Ok(match compared.results.iter().all(|results| results.is_within) {
            false => Exit::Failed,
            true if compared.has_claim(Judgement::Undecided) => Exit::Undecided,
            true => Exit::Success,
        })
    }
}

fn refused(error: impl Display) -> Exit {
    complain_of(error);
    Exit::Invalid
}

fn nothing(a: &Path, b: &Path) -> Exit {
    complain(&format!("nothing to compare: no runs in {} and {}", a.display(), b.display()));
    Exit::Nothing
}

fn json(value: &impl Serialize) -> Result<String, Exit> {
    serde_json::to_string_pretty(value).map(|text| format!("{text}\n")).map_err(refused)
}

/// Why a threshold of a column cannot be read.
#[derive(Debug, thiserror::Error)]
enum ThresholdError {
    #[error("`{0}` is not of the form COLUMN=ABS[,REL]")]
    Form(String),
    #[error("`{0}`: {1}")]
    Number(String, NumberError),
}

fn threshold(text: &str) -> Result<(String, Tolerance), ThresholdError> {
    let (column, values) = text.split_once('=').ok_or_else(|| ThresholdError::Form(text.to_owned()))?;
    let (absolute, relative) = values.split_once(',').unwrap_or((values, "0"));
    let allowed = |part: &str| numbers::allowed(part).map_err(|error| ThresholdError::Number(part.to_owned(), error));
    Ok((column.trim().to_owned(), Tolerance { absolute: allowed(absolute)?, relative: allowed(relative)? }))
}
