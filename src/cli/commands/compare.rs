//! `runner compare`: lists differences between two results.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::results::compare::{Limits, Results, Tolerance, compare};
use clap::{Args, ValueEnum};

use crate::cli::Exit;
use crate::cli::arguments::numbers::{self, NumberError};
use crate::cli::terminal::{complain, complain_of, print};

/// Arguments of `compare`.
#[derive(Args, Debug)]
pub struct Compare {
    /// A folder of results, summary.csv, summary.parquet or runs.jsonl
    a: PathBuf,
    /// The same, from another version, machine or date
    b: PathBuf,
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
    /// Compare times too: B may take up to this many times as long as A
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
        let refused = |error: &dyn std::error::Error| {
            complain_of(error);
            Exit::Invalid
        };
        let limits = Limits {
            default: Tolerance { absolute: self.absolute, relative: self.relative },
            columns: self.thresholds.into_iter().collect::<BTreeMap<_, _>>(),
            timing: self.timing,
        };
        let [a, b] = [&self.a, &self.b].map(|path| Results::open(path).map_err(|error| refused(&error)));
        let (mut a, mut b) = (a?, b?);
        if a.is_empty() && b.is_empty() {
            complain(&format!("nothing to compare: no runs in {} and {}", a.path.display(), b.path.display()));
            return Err(Exit::Nothing);
        }
        let changes = compare(&mut a, &mut b, &limits).map_err(|error| refused(&error))?;
        print(&match self.format {
            Format::Text => format!("A: {}\nB: {}\n{changes}", a.path.display(), b.path.display()),
            Format::Json => match serde_json::to_string_pretty(&changes) {
                Ok(text) => format!("{text}\n"),
                Err(error) => return Err(refused(&error)),
            },
        })?;
        Ok(if changes.is_within() { Exit::Success } else { Exit::Failed })
    }
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
