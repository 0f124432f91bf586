//! The head of the page: runs, outcomes, programs, machines and dates.

use crate::report::table::{Cell, Head, Part, Table};
use crate::results::RunStatistics;
use crate::sim::Outcome;
use crate::text::plural::plural;
use crate::text::utc_date::utc;
use serde::Serialize;

/// The head of the page.
#[derive(Debug, Serialize)]
pub(super) struct Overview {
    /// `12 runs of 2 scenarios`
    pub runs: String,
    /// Number of runs by outcome.
    pub outcomes: Vec<Count>,
    /// `30 of 31 expectations held`; empty when nothing was expected.
    pub expectations: String,
    pub programs: Vec<String>,
    pub machines: Vec<String>,
    /// Dates on which the records were written.
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

pub(super) fn head(statistics: &RunStatistics) -> Overview {
    let all = statistics.total();
    Overview {
        runs: format!("{} of {}", plural(all.runs, "run"), plural(statistics.scenarios().len(), "scenario")),
        outcomes: outcomes(&all.outcomes),
        expectations: expectations(all.held, all.expected),
        programs: statistics.programs(),
        machines: statistics.machines(),
        dates: dates(statistics),
        scenarios: table(statistics),
    }
}

/// Passed runs first, then by number.
fn outcomes(counts: &[(&'static str, usize)]) -> Vec<Count> {
    let mut counts: Vec<Count> = counts.iter().map(|&(outcome, count)| Count { outcome, count }).collect();
    counts.sort_by_key(|c| (c.outcome != Outcome::Passed.name(), std::cmp::Reverse(c.count)));
    counts
}

fn expectations(held: usize, all: usize) -> String {
    if all == 0 { String::new() } else { format!("{held} of {all} expectations held") }
}

/// Dates on which the first and the last record were written.
fn dates(statistics: &RunStatistics) -> String {
    let (first, last) = statistics.recorded().unzip();
    match (first.and_then(utc), last.and_then(utc)) {
        (Some(first), Some(last)) if first == last => first,
        (Some(first), Some(last)) => format!("{first} to {last}"),
        _ => String::new(),
    }
}

fn table(statistics: &RunStatistics) -> Table {
    let row = |sums: &crate::results::ScenarioStatistics| {
        let counts = outcomes(&sums.outcomes).into_iter().map(|c| format!("{} {}", c.count, c.outcome));
        vec![
            Cell::text(&sums.scenario),
            Cell::count(sums.runs as u64),
            Cell::text(counts.collect::<Vec<_>>().join(", ")),
            Cell::text(expectations(sums.held, sums.expected).replace(" expectations held", "")),
            Cell::number(Some(sums.simulated_s)),
            Cell::number(Some(sums.cpu_s)),
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
        parts: vec![Part { title: String::new(), rows: statistics.scenarios().iter().map(row).collect() }],
        more: String::new(),
    }
}
