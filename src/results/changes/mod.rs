//! What differs between two results: the same runs before and after a change of the program or of the machine.
//!
//! ```text
//! two files -> Results -> pair (rows of the same run) -> compare (column by column, against Limits) -> Changes
//! ```
//!
//! Two numbers agree when `|a - b| <= absolute + relative max(|a|, |b|)`. Equal infinities agree, and so do two that are no
//! numbers; an empty cell agrees with an empty one only. Times are no results: they are looked at only when asked for.

mod columns;
mod pair;
mod results;
mod show;

use serde::Serialize;

pub use columns::{Limits, Tolerance, UnknownColumn};
pub use results::{Results, ResultsError, Row};

use columns::Kind;

/// What differs between results A and B.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Changes {
    /// Rows of the same run in both.
    pub matched: usize,
    /// Of these, rows that were found by their keys; the others by scenario, swept parameters, method, integrator and seed.
    pub matched_by_key: usize,
    /// Runs of A that B lacks.
    pub only_in_a: Vec<String>,
    /// Runs of B that A lacks.
    pub only_in_b: Vec<String>,
    /// Columns that only one of them has and that were not compared.
    pub columns_in_one: Vec<String>,
    /// Runs that ended in another way.
    pub outcomes: Vec<OutcomeChange>,
    /// Values beyond what is allowed, in the order of A's rows.
    pub beyond: Vec<Difference>,
    /// Every column in which something differs at all.
    pub columns: Vec<ColumnChange>,
}

/// A run that ended in another way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutcomeChange {
    /// The run.
    pub run: String,
    /// In A.
    pub a: String,
    /// In B.
    pub b: String,
}

/// A value that differs by more than is allowed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The run.
    pub run: String,
    /// The column.
    pub column: String,
    /// In A, as written; empty when there is none.
    pub a: String,
    /// In B.
    pub b: String,
    /// Their distance; none when one of them is no number.
    pub distance: Option<f64>,
    /// The distance allowed; for a time the factor.
    pub allowed: f64,
}

/// What differs in a column.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnChange {
    /// Its name.
    pub column: String,
    /// Rows that differ.
    pub differ: usize,
    /// Of these, rows beyond what is allowed.
    pub beyond: usize,
    /// Greatest distance, where both are numbers.
    pub greatest: f64,
    /// Greatest distance as a part of the greater of the two.
    pub greatest_relative: f64,
}

impl Changes {
    /// Is all the same, within what is allowed?
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
    let pairs = pair::pair(a, b);
    let (common, alone) = columns::common(a, b);
    let mut changes = Changes {
        matched: pairs.matched.len(),
        matched_by_key: pairs.by_key,
        only_in_a: pairs.only_in_a.iter().map(|row| row.label()).collect(),
        only_in_b: pairs.only_in_b.iter().map(|row| row.label()).collect(),
        columns_in_one: alone,
        ..Changes::default()
    };
    let compared: Vec<(String, Kind)> =
        common.into_iter().filter_map(|name| limits.kind(&name).map(|kind| (name, kind))).collect();
    let mut found: Vec<ColumnChange> = compared.iter().map(|(name, _)| ColumnChange::none(name)).collect();
    for (row_a, row_b) in &pairs.matched {
        let run = row_a.label();
        let (outcome_a, outcome_b) = (row_a.text("outcome"), row_b.text("outcome"));
        if outcome_a != outcome_b {
            changes.outcomes.push(OutcomeChange { run: run.clone(), a: outcome_a.into(), b: outcome_b.into() });
        }
        for ((column, kind), found) in compared.iter().zip(&mut found) {
            let (a, b) = (row_a.text(column), row_b.text(column));
            if let Some(judged) = kind.judge(a, b) {
                found.take(&judged);
                if judged.beyond {
                    let (run, column, a, b) = (run.clone(), column.clone(), a.into(), b.into());
                    let (distance, allowed) = (judged.distance, judged.allowed);
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

    fn take(&mut self, judged: &columns::Judged) {
        self.differ += 1;
        self.beyond += usize::from(judged.beyond);
        self.greatest = self.greatest.max(judged.distance.unwrap_or(0.0));
        self.greatest_relative = self.greatest_relative.max(judged.relative.unwrap_or(0.0));
    }
}
