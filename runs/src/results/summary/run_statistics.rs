//! Streaming statistics over runs, by scenario.

use crate::results::{Machine, SummaryRow};
use crate::sim::Outcome;
use crate::text::plural::plural;
use std::collections::{BTreeMap, BTreeSet};
use std::time::SystemTime;

/// Statistics of all runs added so far.
#[derive(Clone, Debug, Default)]
pub struct RunStatistics {
    /// In the order in which the scenarios first appear.
    scenarios: Vec<ScenarioStatistics>,
    /// Positions in `scenarios` by name.
    positions: BTreeMap<String, usize>,
    programs: BTreeSet<String>,
    machines: BTreeSet<String>,
    recorded: Option<(SystemTime, SystemTime)>,
}

/// Statistics of the runs of one scenario.
#[derive(Clone, Debug, Default)]
pub struct ScenarioStatistics {
    /// Its name.
    pub scenario: String,
    /// Number of its runs.
    pub runs: usize,
    /// Runs by outcome, in the order of [`Outcome::ALL`].
    pub outcomes: Vec<(&'static str, usize)>,
    /// Expectations.
    pub expected: usize,
    /// Expectations that held.
    pub held: usize,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Processor time, s.
    pub cpu_s: f64,
}

impl RunStatistics {
    /// Adds a run; `origin` is its program and machine and `recorded` when its `run.json` was written,
    /// if they are known.
    pub fn add(&mut self, row: &SummaryRow, origin: Option<(&str, &Machine)>, recorded: Option<SystemTime>) {
        let position = *self.positions.entry(row.scenario.clone()).or_insert_with(|| {
            self.scenarios.push(ScenarioStatistics { scenario: row.scenario.clone(), ..Default::default() });
            self.scenarios.len() - 1
        });
        self.scenarios[position].add(row);
        if let Some((program, machine)) = origin {
            if !self.programs.contains(program) {
                self.programs.insert(program.to_owned());
            }
            self.machines.insert(format!("{} {}, {}", machine.os, machine.arch, plural(machine.cpus, "processor")));
        }
        if let Some(at) = recorded {
            let (first, last) = self.recorded.unwrap_or((at, at));
            self.recorded = Some((first.min(at), last.max(at)));
        }
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.scenarios.iter().map(|s| s.runs).sum()
    }

    /// Runs by outcome.
    pub fn outcomes(&self) -> Vec<(&'static str, usize)> {
        self.total().outcomes
    }

    /// Expectations: held, and all.
    pub fn expectations(&self) -> (usize, usize) {
        let total = self.total();
        (total.held, total.expected)
    }

    /// Each scenario, in the order of their first runs.
    pub fn scenarios(&self) -> &[ScenarioStatistics] {
        &self.scenarios
    }

    /// Programs that made the runs, sorted.
    pub fn programs(&self) -> Vec<String> {
        self.programs.iter().cloned().collect()
    }

    /// Machines that made the runs, sorted.
    pub fn machines(&self) -> Vec<String> {
        self.machines.iter().cloned().collect()
    }

    /// Times of modification of the first and the last record.
    pub fn recorded(&self) -> Option<(SystemTime, SystemTime)> {
        self.recorded
    }

    /// Counts over all scenarios; times are not summed.
    pub fn total(&self) -> ScenarioStatistics {
        let mut total = ScenarioStatistics::default();
        for s in &self.scenarios {
            s.outcomes.iter().for_each(|(outcome, count)| total.count(outcome, *count));
            total.runs += s.runs;
            total.expected += s.expected;
            total.held += s.held;
        }
        total
    }
}

impl ScenarioStatistics {
    fn add(&mut self, row: &SummaryRow) {
        self.runs += 1;
        self.count(row.outcome.name(), 1);
        self.expected += row.verdicts.len();
        self.held += row.verdicts.iter().filter(|v| v.held).count();
        // Unmeasured values are left out of sums.
        self.simulated_s += Some(row.metrics.duration_s).filter(|x| x.is_finite()).unwrap_or(0.0);
        self.cpu_s += Some(row.cpu_s).filter(|x| x.is_finite()).unwrap_or(0.0);
    }

    fn count(&mut self, outcome: &'static str, runs: usize) {
        match self.outcomes.iter_mut().find(|(known, _)| *known == outcome) {
            Some((_, count)) => *count += runs,
            None => {
                self.outcomes.push((outcome, runs));
                let rank = |name: &str| Outcome::ALL.iter().position(|o| o.name() == name);
                self.outcomes.sort_by_key(|(name, _)| rank(name));
            }
        }
    }
}
