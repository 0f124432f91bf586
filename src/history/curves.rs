//! The values of a metric over the results of a history, for pictures.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::compare::{Limits, RunDigest, is_measured};
use crate::history::History;

/// Greatest number of results of a curve: the newest ones.
const MAX_RESULTS: usize = 50;

/// Greatest number of curves of a metric.
pub(super) const MAX_CURVES: usize = 6;

/// A metric of a scenario over the results.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricCurves {
    /// Name of the scenario.
    pub scenario: String,
    /// The metric.
    pub column: String,
    /// Title and date of each result.
    pub results: Vec<(String, String)>,
    /// Curves of runs, those with the greatest relative change first.
    pub curves: Vec<Curve>,
    /// Runs of the scenario without a curve here.
    pub left_out: usize,
    /// True if a value changed by more than the default tolerances.
    pub is_changed: bool,
}

/// The values of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Swept values that distinguish the run; empty for the only run of a scenario.
    pub run: String,
    /// A value per result, or none.
    pub values: Vec<Option<f64>>,
}

/// The metrics of scenarios that changed over the newest results, and those that claims name: `named`
/// are scenarios with columns. Times are left out, unless a claim names them.
pub fn metric_curves(
    history: &History,
    scenarios: &BTreeSet<String>,
    named: &BTreeSet<(String, String)>,
) -> Vec<MetricCurves> {
    let limits = Limits::default();
    let mut found = Vec::new();
    for scenario in scenarios {
        let has = |rows: std::ops::Range<usize>| history.runs[rows].iter().any(|run| run.own[0] == *scenario);
        let mut entries: Vec<_> = history.entries.iter().filter(|entry| has(entry.rows.clone())).collect();
        entries.drain(..entries.len().saturating_sub(MAX_RESULTS));
        let mut runs: HashMap<(RunDigest, usize), usize> = HashMap::new();
        // Row of each run in each result, runs in the order of their appearance.
        let mut rows: Vec<Vec<Option<usize>>> = Vec::new();
        for (at, entry) in entries.iter().enumerate() {
            for row in entry.rows.clone().filter(|row| history.runs[*row].own[0] == *scenario) {
                let index = *runs.entry(history.runs[row].identity).or_insert_with(|| {
                    rows.push(vec![None; entries.len()]);
                    rows.len() - 1
                });
                rows[index][at] = Some(row);
            }
        }
        let labels = labels(history, &rows);
        let results: Vec<(String, String)> = entries.iter().map(|entry| (entry.title(), entry.date())).collect();
        for (column, metric) in history.metrics.iter().filter(|(name, _)| is_measured(name)) {
            let is_named = named.contains(&(scenario.clone(), column.clone()));
            let Some(check) = limits.check_of(column).or_else(|| is_named.then(|| limits.default.into())) else {
                continue;
            };
            let values = |rows: &Vec<Option<usize>>| -> Vec<Option<f64>> {
                rows.iter().map(|row| row.and_then(|row| metric.get(row)).filter(|x| x.is_finite())).collect()
            };
            // Greatest difference of neighbours, relative to the greater.
            let change = |values: &[Option<f64>]| {
                let known: Vec<f64> = values.iter().copied().flatten().collect();
                let pairs = known.windows(2).filter_map(|pair| check.difference_of(pair[0], pair[1]));
                let beyond = pairs.filter(|difference| difference.beyond);
                beyond.filter_map(|difference| difference.relative).fold(0.0, f64::max)
            };
            let mut curves: Vec<(f64, Curve)> = rows
                .iter()
                .zip(&labels)
                .map(|(rows, run)| (values(rows), run))
                .filter(|(values, _)| values.iter().any(Option::is_some))
                .map(|(values, run)| (change(&values), Curve { run: run.clone(), values }))
                .collect();
            let is_changed = curves.iter().any(|(change, _)| *change > 0.0);
            if curves.is_empty() || !(is_changed || is_named) {
                continue;
            }
            curves.sort_by(|a, b| b.0.total_cmp(&a.0));
            let left_out = curves.len().saturating_sub(MAX_CURVES);
            let curves = curves.into_iter().take(MAX_CURVES).map(|(_, curve)| curve).collect();
            let (scenario, column, results) = (scenario.clone(), column.clone(), results.clone());
            found.push(MetricCurves { scenario, column, results, curves, left_out, is_changed });
        }
    }
    found
}

/// What distinguishes the runs of a scenario: swept values, seed, method and integrator, as far as they differ.
fn labels(history: &History, rows: &[Vec<Option<usize>>]) -> Vec<String> {
    let newest = |rows: &Vec<Option<usize>>| rows.iter().rev().find_map(|row| *row);
    let parts = |rows: &Vec<Option<usize>>| -> BTreeMap<String, String> {
        let Some(run) = newest(rows).map(|row| &history.runs[row]) else { return BTreeMap::new() };
        let [_, _, _, method, integrator, seed] = &run.own;
        let own = [("method", method), ("integrator", integrator), ("seed", seed)];
        let own = own.map(|(name, value)| (name.to_owned(), value.clone()));
        run.parameters.clone().into_iter().chain(own).collect()
    };
    let all: Vec<BTreeMap<String, String>> = rows.iter().map(parts).collect();
    let differs = |name: &String, value: &String| all.iter().any(|other| other.get(name) != Some(value));
    let label = |own: &BTreeMap<String, String>| {
        let differing = own.iter().filter(|(name, value)| differs(name, value));
        // A swept method is a parameter too.
        let doubles = [("method", "contact.method"), ("integrator", "integrator.method")];
        let is_double = |name: &str| doubles.iter().any(|(short, swept)| *short == name && own.contains_key(*swept));
        let differing = differing.filter(|(name, _)| !is_double(name));
        differing.map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
    };
    all.iter().map(label).collect()
}
