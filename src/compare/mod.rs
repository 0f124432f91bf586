//! Compares two results: the same runs before and after a change of the program or of the machine.
//!
//! ```text
//! two files -> Results -> row_pairs (same run) -> compare (by column, with Limits) -> Changes
//! ```
//!
//! Rows are read one pair at a time, so memory grows by some 100 bytes per run. Rows, claims and searches
//! are those of one batch: they are opened while no batch runs in their folder.
//!
//! Two numbers agree when `|a - b| <= absolute + relative max(|a|, |b|)`. Equal infinities agree,
//! and so do two NaN; an empty cell agrees with an empty one only. Times are not results: they are
//! compared only on request.
//!
//! `table_rows` reads such a file as rows of a summary, for the report. `change_claims` judges claims
//! about changes by the pairs.
//!
//! Imports: `text`, `metrics`, `sim`, `files`, `results`. Used by: `cli`, `history`.

mod change_claims;
mod changes_text;
mod claim_changes;
mod columns;
mod csv_rows;
mod file_spans;
mod json_rows;
mod parquet_rows;
mod result_row;
mod results;
mod row_pairs;
mod row_source;
mod search_changes;
mod table_rows;
mod tolerance;

use serde::Serialize;

pub use change_claims::judge_change_claims;
pub use claim_changes::ClaimChange;
pub(super) use columns::{Columns, RunDigest, digest, is_measured};
pub use result_row::ResultRow;
pub(super) use results::HISTORY_COLUMNS;
pub use results::{Results, ResultsError};
pub(super) use row_pairs::{identity, identity_of, same_text};
pub use row_source::ResultsErrorCause;
pub(super) use row_source::Rows;
pub use search_changes::SearchChange;
pub use table_rows::{TableRows, read_table};
pub(super) use tolerance::ColumnCheck;
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
    /// Claims of both with different verdicts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<ClaimChange>,
    /// Searches of both that found different values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub searches: Vec<SearchChange>,
    /// Values beyond the tolerance, in the order of A's rows.
    pub beyond: Vec<Difference>,
    /// Columns with any difference.
    pub columns: Vec<ColumnChange>,
    /// Numbers of entries that the lists above do not have, since they are longer than
    /// [`MAX_ENTRIES`].
    #[serde(skip_serializing_if = "Omitted::is_none")]
    pub omitted: Omitted,
}

/// Greatest number of entries of a list of [`Changes`].
pub const MAX_ENTRIES: usize = 100_000;

/// Entries left out of the lists of [`Changes`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Omitted {
    /// Of `only_in_a`.
    pub only_in_a: usize,
    /// Of `only_in_b`.
    pub only_in_b: usize,
    /// Of `outcomes`.
    pub outcomes: usize,
    /// Of `beyond`.
    pub beyond: usize,
}

impl Omitted {
    fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// Why two results cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The limits name a column that neither of them has.
    #[error(transparent)]
    Column(#[from] UnknownColumn),
    /// One of them cannot be read.
    #[error(transparent)]
    Results(#[from] ResultsError),
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
    /// True if all runs match within the tolerances, claims have the same verdicts, and searches found the
    /// same.
    pub fn is_within(&self) -> bool {
        let missing = !self.only_in_a.is_empty() || !self.only_in_b.is_empty();
        let verdicts = self.outcomes.is_empty() && self.claims.is_empty() && self.searches.is_empty();
        !missing && verdicts && self.beyond.is_empty()
    }
}

/// Compares two results.
///
/// # Errors
/// The limits name a column that neither of them has; a row cannot be read.
pub fn compare(a: &mut Results, b: &mut Results, limits: &Limits) -> Result<Changes, CompareError> {
    limits.check(a, b)?;
    let pairs = row_pairs::pair(a, b)?;
    let (common, alone) = tolerance::common(a, b);
    let mut changes = Changes { matched_by_key: pairs.by_key, columns_in_one: alone, ..Changes::default() };
    let compared: Vec<ComparedColumn> =
        common.into_iter().filter_map(|name| ComparedColumn::new(name, a, b, limits)).collect();
    let mut found: Vec<ColumnChange> = compared.iter().map(|column| ColumnChange::none(&column.name)).collect();
    let (mut row_a, mut row_b) = (a.blank_row(), b.blank_row());
    for (position, partner) in pairs.partner.iter().enumerate() {
        a.read(position, &mut row_a)?;
        let Some(partner) = *partner else {
            push(&mut changes.only_in_a, &mut changes.omitted.only_in_a, || row_a.label());
            continue;
        };
        b.read(partner, &mut row_b)?;
        changes.matched += 1;
        let (outcome_a, outcome_b) = (row_a.text("outcome"), row_b.text("outcome"));
        if outcome_a != outcome_b {
            push(&mut changes.outcomes, &mut changes.omitted.outcomes, || OutcomeChange {
                run: row_a.label(),
                a: outcome_a.into(),
                b: outcome_b.into(),
            });
        }
        for (column, found) in compared.iter().zip(&mut found) {
            let (a, b) = (row_a.cell(column.in_a), row_b.cell(column.in_b));
            let Some(difference) = column.check.difference(a, b) else { continue };
            found.add(&difference);
            if difference.beyond {
                push(&mut changes.beyond, &mut changes.omitted.beyond, || Difference {
                    run: row_a.label(),
                    column: column.name.clone(),
                    a: a.into(),
                    b: b.into(),
                    distance: difference.distance,
                    allowed: difference.allowed,
                });
            }
        }
    }
    for position in pairs.only_in_b {
        b.read(position, &mut row_b)?;
        push(&mut changes.only_in_b, &mut changes.omitted.only_in_b, || row_b.label());
    }
    changes.claims = claim_changes::claim_changes(a, b);
    changes.searches = search_changes::search_changes(a, b);
    changes.columns = found.into_iter().filter(|column| column.differ > 0).collect();
    Ok(changes)
}

/// Adds an entry to a list, or counts it if the list is long.
fn push<T>(list: &mut Vec<T>, omitted: &mut usize, entry: impl FnOnce() -> T) {
    if list.len() < MAX_ENTRIES { list.push(entry()) } else { *omitted += 1 }
}

/// A column that both results have.
struct ComparedColumn {
    name: String,
    check: ColumnCheck,
    /// Its position in A and in B.
    in_a: usize,
    in_b: usize,
}

impl ComparedColumn {
    /// None if the column is not compared.
    fn new(name: String, a: &Results, b: &Results, limits: &Limits) -> Option<Self> {
        let (check, in_a, in_b) = (limits.check_of(&name)?, a.position(&name)?, b.position(&name)?);
        Some(Self { name, check, in_a, in_b })
    }
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
