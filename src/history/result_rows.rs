//! The rows of a result as a table of the history, and the digest that identifies the result.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::UNIX_EPOCH;

use polars::prelude::{Column, DataFrame, NamedFrom, Series};

use crate::compare::{Results, ResultsError, digest, is_measured, same_text};
use crate::files::{KeyLevels, names};
use crate::history::columns::{CLAIMS, HISTORY_SCHEMA, IDENTITY, LABEL, PARAMETERS, PROGRAM, RECORDED};
use crate::history::columns::{RESULT, SCHEMA, TEXTS};
use crate::history::{HistoryError, HistoryErrorCause};
use crate::results::RunRecord;
use crate::results::claims::ClaimVerdict;

/// Digest of a result: of the identity and all measured values of its runs, in any order and format.
///
/// # Errors
/// A row cannot be read.
pub(super) fn result_digest(results: &mut Results) -> Result<String, ResultsError> {
    let measured: Vec<(String, usize)> = measured_columns(results);
    let mut row = results.blank_row();
    let mut rows = Vec::with_capacity(results.len());
    for position in 0..results.len() {
        results.read(position, &mut row)?;
        let mut parts: Vec<String> = IDENTITY.map(|name| row.text(name).to_owned()).into();
        parts.extend(row.parameters().flat_map(|(name, value)| [name.to_owned(), same_text(value)]));
        for (name, at) in &measured {
            match row.cell(*at) {
                "" => {}
                cell => parts.extend([name.clone(), same_text(cell)]),
            }
        }
        rows.push(digest(parts.iter().map(String::as_str)));
    }
    rows.sort_unstable();
    let mut hasher = blake3::Hasher::new();
    for row in &rows {
        hasher.update(row);
    }
    Ok(hasher.finalize().to_hex()[..16].to_owned())
}

/// Measured columns in the order of their names, with their positions.
fn measured_columns(results: &Results) -> Vec<(String, usize)> {
    let columns = results.columns().iter().filter(|name| is_measured(name));
    let mut found: Vec<_> = columns.filter_map(|name| Some((name.clone(), results.position(name)?))).collect();
    found.sort_unstable();
    found
}

/// The rows of a result under its digest and label.
///
/// # Errors
/// A row or `claims.json` cannot be read; a measured value is not a number.
pub(super) fn result_frame(
    results: &mut Results,
    result: &str,
    label: Option<&str>,
) -> Result<DataFrame, HistoryError> {
    let path = results.path.clone();
    let fail = |cause| HistoryError { path: path.clone(), cause };
    let unread = |error: ResultsError| fail(HistoryErrorCause::Results(error.cause));
    let since = results.modified().and_then(|modified| modified.duration_since(UNIX_EPOCH).ok());
    let recorded = since.map_or(0, |since| since.as_secs() as i64);
    let claims = results.claims().to_vec();
    let rows = results.len();
    let measured = measured_columns(results);
    let mut texts: Vec<Vec<Option<String>>> = TEXTS.iter().map(|_| Vec::with_capacity(rows)).collect();
    let mut metrics: Vec<Vec<Option<f64>>> = measured.iter().map(|_| Vec::with_capacity(rows)).collect();
    let mut programs: BTreeMap<String, Option<String>> = BTreeMap::new();
    let (folder, mut row) = (results.folder().to_owned(), results.blank_row());
    for position in 0..rows {
        results.read(position, &mut row).map_err(unread)?;
        let scenario = row.text("scenario");
        let is_first = !programs.contains_key(scenario);
        if is_first {
            programs.insert(scenario.to_owned(), program(&folder, scenario, row.text("key")));
        }
        let text = |name: &str| match name {
            RESULT => Some(result.to_owned()),
            LABEL => label.map(str::to_owned),
            PROGRAM => programs.get(scenario).cloned().flatten(),
            PARAMETERS => Some(parameters_text(row.parameters())).filter(|text| text != "{}"),
            CLAIMS => is_first.then(|| claims_text(&claims, scenario)).flatten(),
            other => Some(row.text(other).to_owned()).filter(|text| !text.is_empty()),
        };
        TEXTS.iter().zip(&mut texts).for_each(|(name, cells)| cells.push(text(name)));
        for ((name, at), cells) in measured.iter().zip(&mut metrics) {
            cells.push(match row.cell(*at) {
                "" => None,
                cell => Some(cell.parse().map_err(|_| {
                    let (column, found) = (name.clone(), format!("`{cell}`"));
                    fail(HistoryErrorCause::Cell { row: position + 1, column, found, expected: "a number" })
                })?),
            });
        }
    }
    let schema = Series::new(SCHEMA.into(), vec![HISTORY_SCHEMA; rows]);
    let recorded = Series::new(RECORDED.into(), vec![recorded; rows]);
    let texts = TEXTS.iter().zip(texts).map(|(name, cells)| Series::new((*name).into(), cells));
    // Columns that no run has measured are left out.
    let metrics = measured.iter().zip(metrics).filter(|(_, cells)| cells.iter().any(Option::is_some));
    let metrics = metrics.map(|((name, _), cells)| Series::new(name.as_str().into(), cells));
    let all = [schema, recorded].into_iter().chain(texts).chain(metrics).map(Column::from).collect();
    DataFrame::new(rows, all).map_err(|error| fail(error.into()))
}

/// Program and version by the record of a run; none without a record.
fn program(folder: &Path, scenario: &str, key: &str) -> Option<String> {
    let is_plain = |name: &str| crate::files::confined::is_plain(name);
    let folder = Some(folder.join(scenario)).filter(|_| is_plain(scenario) && is_plain(key))?;
    let record = KeyLevels::all().map(|levels| folder.join(levels.folder(key)).join(names::RUN_RECORD));
    let record = record.into_iter().find(|path| path.is_file())?;
    RunRecord::read(&record).ok().map(|record| record.program)
}

/// Swept parameters as JSON.
fn parameters_text<'a>(parameters: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let parameters: BTreeMap<&str, &str> = parameters.collect();
    serde_json::to_string(&parameters).unwrap_or_default()
}

/// Results of the claims of a scenario as JSON, without their history; none without claims.
fn claims_text(claims: &[ClaimVerdict], scenario: &str) -> Option<String> {
    let own = claims.iter().filter(|claim| claim.scenario == scenario);
    let own: Vec<_> = own.map(|claim| ClaimVerdict { trace: Vec::new(), ..claim.clone() }).collect();
    if own.is_empty() { None } else { serde_json::to_string(&own).ok() }
}
