//! The newest rows of a history as results to compare with.

use std::collections::{BTreeMap, BTreeSet};

use crate::compare::{Columns, Results, ResultsErrorCause, Rows, digest};
use crate::history::History;
use crate::history::columns::IDENTITY;
use crate::metrics;
use crate::results::claims::ClaimVerdict;

/// Cells of the newest rows.
struct NewestRows(Vec<Vec<String>>);

impl Rows for NewestRows {
    fn read(&mut self, position: usize, _: &Columns, cells: &mut [String]) -> Result<(), ResultsErrorCause> {
        cells.iter_mut().zip(&self.0[position]).for_each(|(cell, text)| cell.push_str(text));
        Ok(())
    }
}

impl History {
    /// For each of the scenarios its runs in the newest result that has it, without the result with
    /// the digest `except`; and the results of their claims.
    pub(super) fn newest(&self, scenarios: &BTreeSet<String>, except: &str) -> Results {
        let mut newest: BTreeMap<&str, usize> = BTreeMap::new();
        for (index, entry) in self.entries.iter().enumerate().filter(|(_, entry)| entry.result != except) {
            for run in &self.runs[entry.rows.clone()] {
                if scenarios.contains(&run.own[0]) {
                    newest.insert(&run.own[0], index);
                }
            }
        }
        let is_newest = |scenario: &str, index: usize| newest.get(scenario) == Some(&index);
        let mut rows = Vec::new();
        let mut claims: Vec<ClaimVerdict> = Vec::new();
        for (index, entry) in self.entries.iter().enumerate() {
            rows.extend(entry.rows.clone().filter(|row| is_newest(&self.runs[*row].own[0], index)));
            claims.extend(entry.claims.iter().filter(|claim| is_newest(&claim.scenario, index)).cloned());
        }
        let parameters: BTreeSet<&str> =
            rows.iter().flat_map(|row| self.runs[*row].parameters.keys().map(String::as_str)).collect();
        // Columns that none of the rows has are unknown, not empty.
        let metrics: Vec<_> =
            self.metrics.iter().filter(|(_, values)| rows.iter().any(|row| values.get(*row).is_some())).collect();
        let names = IDENTITY.iter().copied().chain(parameters.iter().copied());
        let names = names.chain(metrics.iter().map(|(name, _)| name.as_str()));
        let columns = Columns::new(names.map(str::to_owned));
        let cells = |row: &usize| {
            let run = &self.runs[*row];
            let parameters = parameters.iter().map(|name| run.parameters.get(*name).cloned().unwrap_or_default());
            let values = metrics.iter().map(|(name, values)| cell(name, values.get(*row)));
            run.own.iter().cloned().chain(parameters).chain(values).collect()
        };
        let runs = rows.iter().map(|row| digest([self.runs[*row].own[0].as_str(), self.runs[*row].own[1].as_str()]));
        let runs = runs.collect();
        let cells = NewestRows(rows.iter().map(cells).collect());
        Results::of_rows(&self.path, (columns, runs, Box::new(cells)), claims)
    }
}

/// A value as the summary writes it.
pub(super) fn cell(column: &str, value: Option<f64>) -> String {
    let is_count = || metrics::column(column).is_some_and(|column| column.is_count);
    match value {
        None => String::new(),
        Some(value) if value.fract() == 0.0 && value.abs() < 1e15 && is_count() => format!("{value:.0}"),
        // The shortest text that reads back to the same number.
        Some(value) => format!("{value:?}"),
    }
}
