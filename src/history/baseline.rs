//! Compares results with a baseline: other results, or a history.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::Serialize;

use crate::compare::{Changes, CompareError, Limits, Results, ResultsError, compare, judge_change_claims};
use crate::files::names;
use crate::history::result_rows::result_digest;
use crate::history::series::{HistoryChanges, history_changes};
use crate::history::{Appended, History, HistoryError};
use crate::results::claims::{ClaimVerdict, Judgement};

/// What results are compared with.
pub enum Baseline {
    /// Other results.
    Results(Box<Results>),
    /// The newest results of a history.
    History(Box<History>),
}

/// Why a baseline cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    /// It is no history, or a damaged one.
    #[error(transparent)]
    History(#[from] HistoryError),
    /// Results cannot be read or compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
}

impl From<ResultsError> for BaselineError {
    fn from(error: ResultsError) -> Self {
        BaselineError::Compare(error.into())
    }
}

/// How trends are tested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrendRule {
    /// Greatest number of values of a series: the newest ones.
    pub last: usize,
    /// Probability of a trend where there is none.
    pub level: f64,
}

/// Differences of results from a baseline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResultChanges {
    /// The file of the results.
    pub results: String,
    /// False if the baseline is a history without other results: then nothing is compared.
    pub is_compared: bool,
    /// True without differences, trends and failed claims.
    pub is_within: bool,
    /// Differences; A is the baseline, B are the results.
    pub changes: Changes,
    /// With a history: the last values of each run and metric.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<HistoryChanges>,
    /// Results of the claims about changes.
    pub claims: Vec<ClaimVerdict>,
    /// What was appended to the history.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub appended: Option<Appended>,
}

/// All results with their baseline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// Format version of this object.
    pub schema: u32,
    /// The file of the baseline.
    pub baseline: String,
    /// The results, in the order given.
    pub results: Vec<ResultChanges>,
    /// Counts over all results.
    pub overview: Overview,
}

/// Counts over results.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Overview {
    /// Results.
    pub results: usize,
    /// Results without differences, trends and failed claims.
    pub within: usize,
    /// Trends in all of them.
    pub trends: usize,
    /// Claims about changes, by verdict.
    pub claims: BTreeMap<&'static str, usize>,
    /// Columns with values beyond their tolerances.
    pub columns: Vec<ColumnOverview>,
}

/// A column over results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnOverview {
    /// Its name.
    pub column: String,
    /// Results with values beyond the tolerance.
    pub results: usize,
    /// Rows beyond the tolerance in all of them.
    pub beyond: usize,
    /// Greatest distance.
    pub greatest: f64,
}

impl Baseline {
    /// Opens a history, a summary, or a folder: its results, or `history.parquet` in a folder without.
    ///
    /// # Errors
    /// The file or folder is missing, damaged or of another kind.
    pub fn open(path: &Path) -> Result<Self, BaselineError> {
        let in_folder = path.join(names::HISTORY);
        let has_results = || names::SUMMARIES.iter().any(|name| path.join(name).is_file());
        match path.is_dir() {
            true if in_folder.is_file() && !has_results() => Self::open_history(&in_folder),
            false if History::is_history(path) => Self::open_history(path),
            _ => Ok(Baseline::Results(Box::new(Results::open(path)?))),
        }
    }

    /// Opens a history; one without results if there is none yet.
    ///
    /// # Errors
    /// The file is damaged or of another kind, or has another extension.
    pub fn open_history(path: &Path) -> Result<Self, BaselineError> {
        History::check_name(path)?;
        Ok(Baseline::History(Box::new(History::read_if_present(path)?)))
    }

    /// The file.
    pub fn path(&self) -> &Path {
        match self {
            Baseline::Results(results) => &results.path,
            Baseline::History(history) => &history.path,
        }
    }

    /// True if it has no runs.
    pub fn is_empty(&self) -> bool {
        match self {
            Baseline::Results(results) => results.is_empty(),
            Baseline::History(history) => history.runs.is_empty(),
        }
    }

    /// Compares results with this baseline. A result that the history has is compared with the others.
    ///
    /// # Errors
    /// A row cannot be read; the limits name an unknown column.
    pub fn compare(
        &mut self,
        results: &mut Results,
        limits: &Limits,
        rule: TrendRule,
    ) -> Result<ResultChanges, BaselineError> {
        let path = results.path.display().to_string();
        let (changes, claims, history) = match self {
            Baseline::Results(baseline) => {
                let changes = compare(baseline, results, limits)?;
                (changes, judge_change_claims(baseline, results)?, None)
            }
            Baseline::History(history) => {
                let digest = result_digest(results)?;
                if history.entries.iter().all(|entry| entry.result == digest) {
                    return Ok(ResultChanges::not_compared(path));
                }
                let (scenarios, measured) = contents(results)?;
                let mut newest = history.newest(&scenarios, &digest);
                let mut changes = compare(&mut newest, results, limits)?;
                // A history has no columns without values.
                changes.columns_in_one.retain(|column| newest.position(column).is_some() || measured.contains(column));
                let claims = judge_change_claims(&mut newest, results)?;
                let trends = history_changes((history, &digest), results, limits, (rule.last, rule.level))?;
                (changes, claims, Some(trends))
            }
        };
        let no_trend = history.as_ref().is_none_or(|history| history.trends == 0);
        let no_failure = claims.iter().all(|claim| claim.verdict != Judgement::Fails);
        let is_within = changes.is_within() && no_trend && no_failure;
        Ok(ResultChanges { results: path, is_compared: true, is_within, changes, history, claims, appended: None })
    }
}

impl ResultChanges {
    /// Results for which the history has no others.
    fn not_compared(results: String) -> Self {
        let (changes, history, claims, appended) = Default::default();
        ResultChanges { results, is_compared: false, is_within: true, changes, history, claims, appended }
    }
}

/// Names of the scenarios of results, and of the columns with a value.
fn contents(results: &mut Results) -> Result<(BTreeSet<String>, BTreeSet<String>), ResultsError> {
    let mut unmeasured: Vec<String> = results.columns().to_vec();
    let (mut scenarios, mut measured, mut row) = (BTreeSet::new(), BTreeSet::new(), results.blank_row());
    for position in 0..results.len() {
        results.read(position, &mut row)?;
        if !scenarios.contains(row.text("scenario")) {
            scenarios.insert(row.text("scenario").to_owned());
        }
        measured.extend(unmeasured.extract_if(.., |column| !row.text(column).is_empty()));
    }
    Ok((scenarios, measured))
}

/// Counts over results; columns by the number of results, then by that of rows.
fn overview(results: &[ResultChanges]) -> Overview {
    let mut all = Overview { results: results.len(), ..Overview::default() };
    for result in results {
        all.within += usize::from(result.is_within);
        all.trends += result.history.as_ref().map_or(0, |history| history.trends);
        for claim in &result.claims {
            *all.claims.entry(claim.verdict.name()).or_default() += 1;
        }
        for own in result.changes.columns.iter().filter(|column| column.beyond > 0) {
            let at = all.columns.iter().position(|column| column.column == own.column).unwrap_or_else(|| {
                let column = own.column.clone();
                all.columns.push(ColumnOverview { column, results: 0, beyond: 0, greatest: 0.0 });
                all.columns.len() - 1
            });
            let column = &mut all.columns[at];
            column.results += 1;
            column.beyond += own.beyond;
            column.greatest = column.greatest.max(own.greatest);
        }
    }
    all.columns.sort_by_key(|column| std::cmp::Reverse((column.results, column.beyond)));
    all
}

impl Compared {
    /// Format version.
    pub const SCHEMA: u32 = 1;

    /// All results that were compared with a baseline.
    pub fn new(baseline: &Path, results: Vec<ResultChanges>) -> Self {
        let overview = overview(&results);
        Compared { schema: Self::SCHEMA, baseline: baseline.display().to_string(), results, overview }
    }

    /// True if a claim has this verdict.
    pub fn has_claim(&self, judgement: Judgement) -> bool {
        self.overview.claims.contains_key(judgement.name())
    }
}
