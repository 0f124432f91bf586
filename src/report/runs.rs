//! The table of all runs, their notes and their files.

use crate::report::ReportRun;
use crate::report::labels::{parameters, short};
use crate::report::table::{Cell, Head, Part, Table, bounded};
use crate::results::pareto::{Work, error_columns};
use crate::sim::Outcome;
use std::path::Path;

/// Greatest number of files listed.
const MAX_FILES: usize = 2000;

pub(super) fn runs(runs: &[ReportRun], works: &[Work]) -> Table {
    let (listed, more) = bounded(runs);
    let errors = error_columns(works);
    let repeated = runs.windows(2).any(|pair| pair[0].row.seed != pair[1].row.seed);
    let mut head: Vec<Head> = ["parameters", "method", "integrator"].map(Head::text).into();
    if repeated {
        head.push(Head::number("seed", ""));
    }
    head.extend([
        Head::text("outcome"),
        Head::number("simulated", "s"),
        Head::number("wall", "s"),
        Head::number("cost", "cpu s / s"),
        Head::number("× real time", ""),
        Head::number("steps", ""),
        Head::number("events", ""),
        Head::number("impacts", ""),
    ]);
    head.extend(errors.iter().map(|column| Head::column(column)));
    head.extend(["key", "message"].map(Head::text));
    let row = |&i: &usize| {
        let (row, work) = (runs[i].row, &works[i]);
        let mut cells =
            vec![Cell::text(parameters(row).join(" ")), Cell::unbroken(&row.method), Cell::unbroken(&row.integrator)];
        if repeated {
            cells.push(Cell::count(row.seed));
        }
        cells.extend([
            outcome(&runs[i]),
            Cell::number(Some(row.metrics.duration_s)),
            Cell::number(Some(row.wall_s)),
            Cell::number(work.cost),
            Cell::number(Some(work.real_time_factor)),
            Cell::count(row.metrics.steps),
            Cell::count(row.metrics.events),
            Cell::count(row.metrics.impacts),
        ]);
        cells.extend(errors.iter().map(|column| error(work, column)));
        cells.extend([Cell { text: row.key.clone(), class: "key" }, Cell::text(row.message.clone())]);
        cells
    };
    let parts = listed.chunk_by(|&a, &b| runs[a].row.scenario == runs[b].row.scenario);
    let parts =
        parts.map(|part| Part { title: runs[part[0]].row.scenario.clone(), rows: part.iter().map(row).collect() });
    Table { head, parts: parts.collect(), more }
}

/// The table of reference runs.
pub(super) fn references(runs: &[ReportRun]) -> Table {
    if runs.is_empty() {
        return Table::default();
    }
    let (listed, more) = bounded(runs);
    let heads = [
        Head::text("scenario"),
        Head::text("method"),
        Head::text("integrator"),
        Head::text("outcome"),
        Head::number("simulated", "s"),
        Head::number("wall", "s"),
        Head::number("cost", "cpu s / s"),
        Head::number("steps", ""),
        Head::text("key"),
        Head::text("message"),
    ];
    let row = |&i: &usize| {
        let row = runs[i].row;
        vec![
            Cell::text(row.scenario.clone()),
            Cell::unbroken(&row.method),
            Cell::unbroken(&row.integrator),
            outcome(&runs[i]),
            Cell::number(Some(row.metrics.duration_s)),
            Cell::number(Some(row.wall_s)),
            Cell::number(Work::of(row).cost),
            Cell::count(row.metrics.steps),
            Cell { text: row.key.clone(), class: "key" },
            Cell::text(row.message.clone()),
        ]
    };
    let rows = listed.iter().map(row).collect();
    Table { head: heads.into(), parts: vec![Part { title: String::new(), rows }], more }
}

fn outcome(run: &ReportRun) -> Cell {
    let class = match run.row.outcome {
        _ if run.is_refused() => "bad",
        Outcome::Passed => "good",
        _ => "",
    };
    Cell { text: run.row.outcome.name().into(), class }
}

fn error(work: &Work, column: &str) -> Cell {
    let value = work.errors.iter().find(|(name, _)| name == column).map(|(_, error)| *error);
    let class = if value.is_some_and(|x| !x.is_finite()) { "n bad" } else { "n" };
    Cell { text: value.map_or_else(|| "–".to_owned(), short), class }
}

/// Notes of runs, with scenario and key.
pub(super) fn notes(runs: &[ReportRun]) -> Vec<String> {
    let notes = |run: &ReportRun| {
        let name = format!("{} {}", run.row.scenario, run.row.key);
        run.notes.iter().map(move |note| format!("{name}: {note}")).collect::<Vec<_>>()
    };
    runs.iter().flat_map(notes).take(MAX_FILES).collect()
}

/// Files of the batch, `pending` ones too, and of its runs, relative to the folder of results; and
/// the number of those omitted.
pub(super) fn files(
    results: &Path,
    runs: &[ReportRun],
    references: &[ReportRun],
    pending: &[&str],
) -> (Vec<String>, usize) {
    let is_there = |name: &&str| pending.contains(name) || results.join(name).is_file();
    let batch = crate::files::names::SUMMARIES.into_iter().filter(is_there).map(|name| results.join(name));
    let own = runs.iter().chain(references).flat_map(|run| run.files.iter().cloned());
    let relative = |path: &Path| path.strip_prefix(results).unwrap_or(path).display().to_string();
    let all: Vec<String> = batch.chain(own).map(|path| relative(&path)).collect();
    let more = all.len().saturating_sub(MAX_FILES);
    (all.into_iter().take(MAX_FILES).collect(), more)
}
