//! The section on the history of results: its results, and a picture of each metric that changed or that
//! a claim names.

use std::collections::BTreeSet;

use crate::files::RecordError;
use crate::history::{Curve, Entry, History, MetricCurves, metric_curves};
use crate::metrics::{names_unit, unit};
use crate::report::canvas::swatch;
use crate::report::history_plot::{history_plot, mark, newest, shows_changes};
use crate::report::palette;
use crate::report::table::{Cell, Head, Part, Table};
use crate::results::claims::{ChangeClaim, ClaimVerdict, Judgement};
use crate::text::plural::plural;
use serde::Serialize;

/// Largest number of pictures.
const MAX_PICTURES: usize = 24;

/// Largest number of results in the table: the newest ones.
const MAX_RESULTS: usize = 20;

/// A history for the report, with the claims about changes of its runs.
#[derive(Clone, Copy, Debug)]
pub struct ShownHistory<'a> {
    /// The history.
    pub history: &'a History,
    /// Claims about changes.
    pub changes: &'a [ChangeClaim],
}

/// The section.
#[derive(Debug, Default, Serialize)]
pub(super) struct Section {
    pub table: Table,
    pub scenarios: Vec<Scenario>,
    /// Note on the pictures.
    pub note: String,
}

/// The pictures of a scenario.
#[derive(Debug, Serialize)]
pub(super) struct Scenario {
    pub name: String,
    pub pictures: Vec<Picture>,
}

/// The picture of a metric.
#[derive(Debug, Serialize)]
pub(super) struct Picture {
    pub caption: String,
    /// Run and its mark; empty for a single run.
    pub legend: Vec<(String, String)>,
    /// Runs without a curve.
    pub left_out: String,
    pub svg: String,
}

/// The section on the scenarios of a report, with its claims.
pub(super) fn section(
    shown: Option<ShownHistory>,
    scenarios: &BTreeSet<String>,
    claims: &[ClaimVerdict],
) -> Result<Section, RecordError> {
    let Some(ShownHistory { history, changes }) = shown.filter(|shown| !shown.history.entries.is_empty()) else {
        return Ok(Section::default());
    };
    let of_claims = claims.iter().filter_map(|claim| Some((claim.scenario.clone(), claim.metric.clone()?)));
    let of_changes = changes.iter().filter_map(|own| Some((own.scenario.clone(), own.claim.column()?.to_owned())));
    let named: BTreeSet<(String, String)> = of_claims.chain(of_changes).collect();
    let all = metric_curves(history, scenarios, &named);
    // Metrics of claims, then those that changed, take precedence where not all are drawn.
    let is_named = |metric: &MetricCurves| named.contains(&(metric.scenario.clone(), metric.column.clone()));
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by_key(|at| (!is_named(&all[*at]), !all[*at].is_changed));
    order.truncate(MAX_PICTURES);
    order.sort_unstable();
    let mut found: Vec<Scenario> = Vec::new();
    for metric in order.iter().map(|at| &all[*at]) {
        if found.last().is_none_or(|scenario| scenario.name != metric.scenario) {
            found.push(Scenario { name: metric.scenario.clone(), pictures: Vec::new() });
        }
        if let Some(scenario) = found.last_mut() {
            scenario.pictures.push(picture_of(metric)?);
        }
    }
    let note = match (all.len(), all.len() - order.len()) {
        (0, _) => "No metric changed beyond the default tolerances.".to_owned(),
        (_, 0) => String::new(),
        (_, n) => format!("{} without a picture here", plural(n, "more metric")),
    };
    Ok(Section { table: table(history), scenarios: found, note })
}

fn picture_of(metric: &MetricCurves) -> Result<Picture, RecordError> {
    let name = &metric.column;
    let unit = Some(unit(name)).filter(|unit| !unit.is_empty() && !names_unit(name));
    let caption = unit.map_or_else(|| name.clone(), |unit| format!("{name} ({unit})"));
    let caption = if shows_changes(metric) { format!("{caption}, change since the first value") } else { caption };
    let entry = |(index, curve): (usize, &Curve)| {
        let text = format!("{} ({})", curve.run, newest(&curve.values));
        (text, swatch(Some(mark(index)), palette::curve(index)))
    };
    let legend = match metric.curves.as_slice() {
        [only] if only.run.is_empty() => Vec::new(),
        curves => curves.iter().enumerate().map(entry).collect(),
    };
    let left_out = match metric.left_out {
        0 => String::new(),
        n => format!("and {} with smaller changes", plural(n, "more run")),
    };
    Ok(Picture { caption, legend, left_out, svg: history_plot(metric)? })
}

/// The newest results, the last first.
fn table(history: &History) -> Table {
    let head = vec![
        Head::text("result"),
        Head::text("written"),
        Head::text("program"),
        Head::number("runs", ""),
        Head::text("claims"),
    ];
    let hidden = history.entries.len().saturating_sub(MAX_RESULTS);
    let rows = history.entries.iter().rev().take(MAX_RESULTS).map(row).collect();
    let more = if hidden == 0 { String::new() } else { format!("{} in the file", plural(hidden, "older result")) };
    Table { head, parts: vec![Part { title: String::new(), rows }], more }
}

fn row(entry: &Entry) -> Vec<Cell> {
    let count = |judgement: Judgement| entry.claims.iter().filter(|claim| claim.verdict == judgement).count();
    let counts = [Judgement::Holds, Judgement::Fails, Judgement::Undecided].map(|own| (own, count(own)));
    let parts: Vec<String> =
        counts.iter().filter(|(_, n)| *n > 0).map(|(own, n)| format!("{n} {}", own.name())).collect();
    let class = if count(Judgement::Fails) > 0 { "bad" } else { "" };
    vec![
        Cell::text(entry.label.clone().unwrap_or_default()),
        Cell::unbroken(&entry.date()),
        Cell::text(entry.program.clone().unwrap_or_default()),
        Cell::count(entry.runs() as u64),
        Cell { text: parts.join(", "), class },
    ]
}
