//! The page that lists the runs of a folder.

use crate::view::viewable_runs::ViewableRuns;
use crate::view::viewer_page;
use minijinja::value::Serde;
use minijinja::{Value, context};
use serde::Serialize;

#[derive(Serialize)]
struct Row {
    scenario: String,
    key: String,
    outcome: &'static str,
    method: String,
    duration: String,
    parameters: String,
}

/// Renders the page.
pub(super) fn page(runs: &ViewableRuns) -> String {
    let rows: Vec<Row> = runs.runs().iter().filter_map(|run| run.record.as_deref()).map(row).collect();
    viewer_page::render("list.html", context! { rows => Value::from(Serde(rows)), without => runs.without_log() })
}

fn row(record: &crate::results::RunRecord) -> Row {
    let parameters: Vec<String> = record.parameters.iter().map(|(name, value)| format!("{name} = {value}")).collect();
    Row {
        scenario: record.scenario.clone(),
        key: record.key.clone(),
        outcome: record.outcome.name(),
        method: record.method.clone(),
        duration: format!("{:.3}", record.metrics.duration_s),
        parameters: parameters.join(", "),
    }
}
