//! What was run, where and when.

use super::ReportRun;
use super::table::{Cell, Head, Part, Table};
use super::utc::utc;
use super::words::plural;
use crate::sim::Outcome;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// The head of the page.
#[derive(Debug, Serialize)]
pub(super) struct Overview {
    /// `12 runs of 2 scenarios`
    pub runs: String,
    /// How many ended in each way.
    pub outcomes: Vec<Count>,
    /// `30 of 31 expectations held`; empty when nothing was expected.
    pub expectations: String,
    pub programs: Vec<String>,
    pub machines: Vec<String>,
    /// When the records were written.
    pub dates: String,
    /// One row per scenario.
    pub scenarios: Table,
}

/// Runs of one outcome.
#[derive(Debug, Serialize)]
pub(super) struct Count {
    pub outcome: &'static str,
    pub count: usize,
}

pub(super) fn head(runs: &[ReportRun]) -> Overview {
    let scenarios = by_scenario(runs);
    let (programs, machines): (BTreeSet<_>, BTreeSet<_>) = runs
        .iter()
        .map(|r| {
            let m = r.machine;
            (r.program.to_owned(), format!("{} {}, {}", m.os, m.arch, plural(m.cpus, "processor")))
        })
        .unzip();
    Overview {
        runs: format!("{} of {}", plural(runs.len(), "run"), plural(scenarios.len(), "scenario")),
        outcomes: outcomes(runs.iter()),
        expectations: expectations(runs.iter()),
        programs: programs.into_iter().collect(),
        machines: machines.into_iter().collect(),
        dates: dates(runs),
        scenarios: table(&scenarios),
    }
}

/// In the order in which they are first met.
fn by_scenario<'a>(runs: &'a [ReportRun<'a>]) -> Vec<(&'a str, Vec<&'a ReportRun<'a>>)> {
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    let mut scenarios: Vec<(&str, Vec<&ReportRun>)> = Vec::new();
    for run in runs {
        let place = *places.entry(&run.row.scenario).or_insert(scenarios.len());
        if place == scenarios.len() {
            scenarios.push((&run.row.scenario, Vec::new()));
        }
        scenarios[place].1.push(run);
    }
    scenarios
}

fn outcomes<'a>(runs: impl Iterator<Item = &'a ReportRun<'a>>) -> Vec<Count> {
    let mut counts: Vec<Count> = Vec::new();
    for outcome in runs.map(|r| r.row.outcome.name()) {
        match counts.iter_mut().find(|c| c.outcome == outcome) {
            Some(count) => count.count += 1,
            None => counts.push(Count { outcome, count: 1 }),
        }
    }
    // The good ones first.
    counts.sort_by_key(|c| (c.outcome != Outcome::Passed.name(), std::cmp::Reverse(c.count)));
    counts
}

fn expectations<'a>(runs: impl Iterator<Item = &'a ReportRun<'a>>) -> String {
    let (mut held, mut all) = (0, 0);
    for verdict in runs.flat_map(|r| &r.row.verdicts) {
        all += 1;
        held += usize::from(verdict.held);
    }
    if all == 0 { String::new() } else { format!("{held} of {all} expectations held") }
}

/// When the records were written, from the first to the last.
fn dates(runs: &[ReportRun]) -> String {
    let modified = |run: &ReportRun| run.file("run.json")?.metadata().ok()?.modified().ok();
    let (first, last) = (runs.iter().filter_map(modified).min(), runs.iter().filter_map(modified).max());
    match (first.and_then(utc), last.and_then(utc)) {
        (Some(first), Some(last)) if first == last => first,
        (Some(first), Some(last)) => format!("{first} to {last}"),
        _ => String::new(),
    }
}

fn table(scenarios: &[(&str, Vec<&ReportRun>)]) -> Table {
    let row = |(name, runs): &(&str, Vec<&ReportRun>)| {
        let sum =
            |of: fn(&ReportRun) -> f64| Cell::number(Some(runs.iter().map(|r| of(r)).filter(|x| x.is_finite()).sum()));
        let words = outcomes(runs.iter().copied()).into_iter().map(|c| format!("{} {}", c.count, c.outcome));
        vec![
            Cell::text(*name),
            Cell::count(runs.len() as u64),
            Cell::text(words.collect::<Vec<_>>().join(", ")),
            Cell::text(expectations(runs.iter().copied()).replace(" expectations held", "")),
            sum(|r| r.row.metrics.duration_s),
            sum(|r| r.row.cpu_s),
        ]
    };
    Table {
        head: vec![
            Head::text("scenario"),
            Head::number("runs", ""),
            Head::text("outcomes"),
            Head::text("expectations held"),
            Head::number("simulated", "s"),
            Head::number("processor time", "s"),
        ],
        parts: vec![Part { title: String::new(), rows: scenarios.iter().map(row).collect() }],
        more: String::new(),
    }
}
