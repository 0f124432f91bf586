//! What can be said of any number of runs without having them all at hand.

use crate::results::{Machine, SummaryRow};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::SystemTime;

/// Numbers of all runs, by scenario; kept while runs come and go.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// In the order in which the scenarios were first met.
    scenarios: Vec<Sums>,
    places: BTreeMap<String, usize>,
    programs: BTreeSet<String>,
    machines: BTreeSet<String>,
    recorded: Option<(SystemTime, SystemTime)>,
}

/// What the runs of one scenario come to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sums {
    pub scenario: String,
    pub runs: usize,
    /// How many ended in each way, in the order in which these were first met.
    pub outcomes: Vec<(&'static str, usize)>,
    /// Expectations.
    pub expected: usize,
    /// Those that held.
    pub held: usize,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Processor time, s.
    pub cpu_s: f64,
}

impl Tally {
    /// Counts a run; `record` is its `run.json`, if it has one.
    pub fn add(&mut self, row: &SummaryRow, program: &str, machine: &Machine, record: Option<&Path>) {
        let place = *self.places.entry(row.scenario.clone()).or_insert_with(|| {
            self.scenarios.push(Sums { scenario: row.scenario.clone(), ..Sums::default() });
            self.scenarios.len() - 1
        });
        self.scenarios[place].add(row);
        if !self.programs.contains(program) {
            self.programs.insert(program.to_owned());
        }
        let processors = if machine.cpus == 1 { "processor" } else { "processors" };
        self.machines.insert(format!("{} {}, {} {processors}", machine.os, machine.arch, machine.cpus));
        if let Some(at) = record.and_then(|path| path.metadata().ok()?.modified().ok()) {
            let (first, last) = self.recorded.unwrap_or((at, at));
            self.recorded = Some((first.min(at), last.max(at)));
        }
    }

    /// Runs counted.
    pub fn runs(&self) -> usize {
        self.scenarios.iter().map(|s| s.runs).sum()
    }

    /// How many ended in each way.
    pub fn outcomes(&self) -> Vec<(&'static str, usize)> {
        self.all().outcomes
    }

    /// Expectations: held, and all.
    pub fn expectations(&self) -> (usize, usize) {
        let all = self.all();
        (all.held, all.expected)
    }

    pub(crate) fn scenarios(&self) -> &[Sums] {
        &self.scenarios
    }

    pub(crate) fn programs(&self) -> Vec<String> {
        self.programs.iter().cloned().collect()
    }

    pub(crate) fn machines(&self) -> Vec<String> {
        self.machines.iter().cloned().collect()
    }

    /// When the first and the last record were written.
    pub(crate) fn recorded(&self) -> Option<(SystemTime, SystemTime)> {
        self.recorded
    }

    pub(crate) fn all(&self) -> Sums {
        let mut all = Sums::default();
        for s in &self.scenarios {
            s.outcomes.iter().for_each(|(outcome, count)| all.count(outcome, *count));
            all.runs += s.runs;
            all.expected += s.expected;
            all.held += s.held;
        }
        all
    }
}

impl Sums {
    fn add(&mut self, row: &SummaryRow) {
        self.runs += 1;
        self.count(row.outcome.name(), 1);
        self.expected += row.verdicts.len();
        self.held += row.verdicts.iter().filter(|v| v.held).count();
        // What was not measured is no part of a sum.
        self.simulated_s += Some(row.metrics.duration_s).filter(|x| x.is_finite()).unwrap_or(0.0);
        self.cpu_s += Some(row.cpu_s).filter(|x| x.is_finite()).unwrap_or(0.0);
    }

    fn count(&mut self, outcome: &'static str, more: usize) {
        match self.outcomes.iter_mut().find(|(known, _)| *known == outcome) {
            Some((_, count)) => *count += more,
            None => self.outcomes.push((outcome, more)),
        }
    }
}
