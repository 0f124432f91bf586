//! Reads the rows of a summary file as [`SummaryRow`]s. The file may come from another program that writes
//! the columns of the summary: then it need not have all of them, and its columns `error_...` have names
//! of its own.

use crate::compare::columns::is_measured;
use crate::compare::result_row::ResultRow;
use crate::compare::{Results, ResultsError};
use crate::metrics::{Metrics, NUMERIC_COLUMNS};
use crate::results::{BoundedSample, Comparison, ParamValue, RunStatistics, SummaryRow, TruthError};
use crate::sim::Outcome;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Rows of a table.
#[derive(Debug, Default)]
pub struct TableRows {
    /// The file.
    pub path: PathBuf,
    /// Statistics of all rows.
    pub statistics: RunStatistics,
    /// A bounded sample of the rows, in their order.
    pub rows: Vec<SummaryRow>,
    /// Numbers of rows that are passed over, by an outcome that this program does not have.
    pub passed_over: BTreeMap<String, usize>,
}

/// Reads a summary (`.csv`, `.parquet`) or `runs.jsonl`.
///
/// # Errors
/// As [`Results::open`] and [`Results::read`].
pub fn read_table(path: &Path) -> Result<TableRows, ResultsError> {
    let mut results = Results::open(path)?;
    let mut table = TableRows { path: results.path.clone(), ..TableRows::default() };
    let columns = results.columns().to_vec();
    let (mut sample, mut row) = (BoundedSample::default(), results.blank_row());
    for index in 0..results.len() {
        results.read(index, &mut row)?;
        match summary_row(&row, &columns) {
            Some(row) => {
                table.statistics.add(&row, None, None);
                sample.insert(index, row.clone(), row.is_refused());
            }
            None => *table.passed_over.entry(row.text("outcome").to_owned()).or_default() += 1,
        }
    }
    table.rows = sample.into_sorted();
    Ok(table)
}

/// The row; none if its outcome is unknown.
fn summary_row(row: &ResultRow, columns: &[String]) -> Option<SummaryRow> {
    let outcome = Outcome::ALL.into_iter().find(|outcome| outcome.name() == row.text("outcome"))?;
    let text = |name: &str| row.text(name).to_owned();
    let number = |name: &str| row.text(name).parse().unwrap_or(f64::NAN);
    let measured = metrics(row);
    let factor = number("real_time_factor");
    Some(SummaryRow {
        scenario: text("scenario"),
        key: text("key"),
        outcome,
        message: text("message"),
        method: text("method"),
        integrator: text("integrator"),
        seed: row.text("seed").parse().unwrap_or(1),
        parameters: row.parameters().map(|(name, value)| (name.to_owned(), parameter(value))).collect(),
        verdicts: Vec::new(),
        comparison: comparison(row, columns),
        wall_s: number("wall_s"),
        cpu_s: number("cpu_s"),
        real_time_factor: if factor.is_nan() { measured.duration_s / number("wall_s") } else { factor },
        metrics: measured,
        repeats: None,
        avoidance: None,
    })
}

fn parameter(text: &str) -> ParamValue {
    let real = || text.parse().ok().filter(|x: &f64| x.is_finite()).map(ParamValue::Number);
    let whole = || text.parse().ok().map(ParamValue::Integer);
    let flag = || text.parse().ok().map(ParamValue::Flag);
    whole().or_else(real).or_else(flag).unwrap_or_else(|| ParamValue::Text(text.to_owned()))
}

/// Metrics of one number each, where the table has them; those of several numbers are left out.
fn metrics(row: &ResultRow) -> Metrics {
    let Ok(Value::Object(mut known)) = serde_json::to_value(Metrics::default()) else { return Metrics::default() };
    for (name, value) in &mut known {
        let text = row.text(name);
        let whole = || text.parse().ok().map(|n: u64| Value::from(n));
        let real = || text.parse().ok().map(|x: f64| Value::from(x));
        if !value.is_array()
            && let Some(number) = whole().or_else(real)
        {
            *value = number;
        }
    }
    // A fraction in a column of counts, say: then none of the columns can be trusted.
    serde_json::from_value(Value::Object(known)).unwrap_or_default()
}

/// Errors of the table's own measures.
fn comparison(row: &ResultRow, columns: &[String]) -> Comparison {
    let own = columns.iter().filter(|name| is_measured(name) && !NUMERIC_COLUMNS.contains(&name.as_str()));
    let truth = own.filter_map(|name| {
        let metric = name.strip_prefix("error_")?.to_owned();
        Some(TruthError { metric, error: Some(row.text(name).parse().ok()?) })
    });
    Comparison { truth: truth.collect(), ..Comparison::default() }
}
