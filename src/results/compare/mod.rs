//! Compares two results: the same runs before and after a change of the program or of the machine.
//!
//! ```text
//! two files -> Results -> row_pairs (same run) -> compare (by column, with Limits) -> Changes
//! ```
//!
//! Two numbers agree when `|a - b| <= absolute + relative max(|a|, |b|)`. Equal infinities agree,
//! and so do two NaN; an empty cell agrees with an empty one only. Times are not results: they are
//! compared only on request.
//!
//! Imports `metrics`, `files`, `text` and the terminal table of `results`. `runner compare` calls
//! it.

mod changes_text;
mod results_file;
mod row_pairs;
mod tolerance;

use serde::Serialize;

pub use results_file::{ResultRow, Results, ResultsError, ResultsErrorCause};
use tolerance::ColumnCheck;
pub use tolerance::{Limits, Tolerance, UnknownColumn};

/// Differences between results A and B.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Changes {
    /// Rows of the same run in both.
    pub matched: usize,
    /// Of these, rows matched by their keys; the others by scenario, swept parameters, method,
    /// integrator and seed.
    pub matched_by_key: usize,
    /// Runs of A that B lacks.
    pub only_in_a: Vec<String>,
    /// Runs of B that A lacks.
    pub only_in_b: Vec<String>,
    /// Columns of only one of the results, not compared.
    pub columns_in_one: Vec<String>,
    /// Runs with different outcomes.
    pub outcomes: Vec<OutcomeChange>,
    /// Values beyond the tolerance, in the order of A's rows.
    pub beyond: Vec<Difference>,
    /// Columns with any difference.
    pub columns: Vec<ColumnChange>,
}

/// A run with different outcomes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutcomeChange {
    /// The run.
    pub run: String,
    /// In A.
    pub a: String,
    /// In B.
    pub b: String,
}

/// A value beyond the tolerance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The run.
    pub run: String,
    /// The column.
    pub column: String,
    /// In A, as written; may be empty.
    pub a: String,
    /// In B.
    pub b: String,
    /// Their distance; none when one of them is not a number.
    pub distance: Option<f64>,
    /// The allowed distance; for a time the allowed factor.
    pub allowed: f64,
}

/// Differences in a column.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnChange {
    /// Its name.
    pub column: String,
    /// Rows that differ.
    pub differ: usize,
    /// Of these, rows beyond the tolerance.
    pub beyond: usize,
    /// Greatest distance, where both are numbers.
    pub greatest: f64,
    /// Greatest distance as a part of the greater of the two.
    pub greatest_relative: f64,
}

impl Changes {
    /// True if all runs match within the tolerances.
    pub fn is_within(&self) -> bool {
        let missing = !self.only_in_a.is_empty() || !self.only_in_b.is_empty();
        !missing && self.outcomes.is_empty() && self.beyond.is_empty()
    }
}

/// Compares two results.
///
/// # Errors
/// The limits name a column that neither of them has.
pub fn compare(a: &Results, b: &Results, limits: &Limits) -> Result<Changes, UnknownColumn> {
    limits.check(a, b)?;
    let pairs = row_pairs::pair(a, b);
    let (common, alone) = tolerance::common(a, b);
    let mut changes = Changes {
        matched: pairs.matched.len(),
        matched_by_key: pairs.by_key,
        only_in_a: pairs.only_in_a.iter().map(|row| row.label()).collect(),
        only_in_b: pairs.only_in_b.iter().map(|row| row.label()).collect(),
        columns_in_one: alone,
        ..Changes::default()
    };
    let compared: Vec<(String, ColumnCheck)> =
        common.into_iter().filter_map(|name| limits.check_of(&name).map(|check| (name, check))).collect();
    let mut found: Vec<ColumnChange> = compared.iter().map(|(name, _)| ColumnChange::none(name)).collect();
    for (row_a, row_b) in &pairs.matched {
        let run = row_a.label();
        let (outcome_a, outcome_b) = (row_a.text("outcome"), row_b.text("outcome"));
        if outcome_a != outcome_b {
            changes.outcomes.push(OutcomeChange { run: run.clone(), a: outcome_a.into(), b: outcome_b.into() });
        }
        for ((column, check), found) in compared.iter().zip(&mut found) {
            let (a, b) = (row_a.text(column), row_b.text(column));
            if let Some(difference) = check.difference(a, b) {
                found.add(&difference);
                if difference.beyond {
                    let (run, column, a, b) = (run.clone(), column.clone(), a.into(), b.into());
                    let (distance, allowed) = (difference.distance, difference.allowed);
                    changes.beyond.push(Difference { run, column, a, b, distance, allowed });
                }
            }
        }
    }
    changes.columns = found.into_iter().filter(|column| column.differ > 0).collect();
    Ok(changes)
}

impl ColumnChange {
    fn none(column: &str) -> Self {
        ColumnChange { column: column.into(), differ: 0, beyond: 0, greatest: 0.0, greatest_relative: 0.0 }
    }

    fn add(&mut self, difference: &tolerance::CellDifference) {
        self.differ += 1;
        self.beyond += usize::from(difference.beyond);
        self.greatest = self.greatest.max(difference.distance.unwrap_or(0.0));
        self.greatest_relative = self.greatest_relative.max(difference.relative.unwrap_or(0.0));
    }
}
