//! The plan of a batch: compact tickets, expanded to jobs on demand.

use crate::files::{KeyLevels, names};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use crate::batch::plan::plan_claims::PlanClaims;
use crate::batch::plan::robot_cache::Robots;
use crate::batch::{Options, Part};
use crate::results::claims::RunClaim;
use crate::results::{ParamValue, is_truth};
use crate::robot::Robot;
use crate::scenario::{Expansion, Run};

/// The runs of a batch in order: 24 bytes per run, from which jobs are built on demand.
#[derive(Clone)]
pub struct Plan {
    pub(in crate::batch) runs: Vec<Ticket>,
    /// Reference runs, each once, in the order of first use.
    pub(in crate::batch) references: Vec<Ticket>,
    pub(in crate::batch) sources: Vec<Arc<Source>>,
    pub(in crate::batch) robots: Arc<Mutex<Robots>>,
    /// Scenario files of the runs.
    pub files: Vec<PathBuf>,
    /// The shard that this plan is; none for a whole plan.
    pub part: Option<Part>,
    /// The claims about the runs of all shards.
    pub(in crate::batch) claims: Arc<PlanClaims>,
    /// The filter that selected the runs.
    pub(in crate::batch) filter: Option<String>,
    /// Hashes of files that the runs use, by their names in the scenarios.
    pub(in crate::batch) used: BTreeMap<String, String>,
    /// Swept parameters that replace those of the runs: on replay, those of the record.
    pub(in crate::batch) swept: Option<Arc<[(String, toml::Value)]>>,
}

/// A checked run, identified by its number in its file's expansion.
#[derive(Clone, Copy, Debug)]
pub(in crate::batch) struct Ticket {
    pub key: u64,
    /// Position of its file among the sources.
    pub source: u32,
    /// Number in its file's expansion; for a reference, that of the first run that needs it.
    pub number: u32,
    /// Position of its reference, or [`NONE`].
    pub reference: u32,
    /// Number of repetitions for timing.
    pub repetitions: u32,
}

pub(in crate::batch) const NONE: u32 = u32::MAX;

/// A scenario file and its expansion.
pub(in crate::batch) struct Source {
    pub expansion: Expansion,
    pub name: String,
    /// Combined traits of its runs.
    pub kind: Traits,
    /// Position of its first run among the runs of all files and shards.
    pub first: usize,
    /// Keys of the runs of a search by their numbers, once they are known; empty without a search.
    pub probe_keys: Vec<OnceLock<u64>>,
}

impl Source {
    /// Folders above those of its runs.
    fn levels(&self) -> KeyLevels {
        KeyLevels::of(self.expansion.runs())
    }
}

/// Combined traits of the runs of a file.
#[derive(Clone, Copy, Default)]
pub(in crate::batch) struct Traits {
    /// True if their seeds differ.
    pub repeated: bool,
    /// True if any of them drives a remote robot.
    pub remote: bool,
}

impl Plan {
    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.runs.len()
    }

    /// Number of runs, references and repetitions in files that drive a remote robot.
    pub fn remote_runs(&self) -> usize {
        let all = self.runs.iter().chain(&self.references);
        let remote = all.filter(|ticket| self.sources[ticket.source as usize].kind.remote);
        remote.map(|ticket| 1 + ticket.repetitions as usize).sum()
    }

    /// Number of references.
    pub fn references(&self) -> usize {
        self.references.len()
    }

    /// Sets the swept parameters that runs report: a resolved scenario sweeps nothing.
    pub fn set_swept_parameters(&mut self, parameters: &[(String, ParamValue)]) {
        self.swept = Some(parameters.iter().map(|(name, value)| (name.clone(), to_toml(value))).collect());
    }

    /// Builds the run at a position.
    pub fn job(&self, index: usize) -> Job {
        self.build(index, self.runs[index], Role::Run { reference: self.reference_of(index) })
    }

    /// Builds the reference at a position.
    pub fn reference(&self, index: usize) -> Job {
        self.build(index, self.references[index], Role::Reference)
    }

    /// Builds all runs in order, one at a time. Those of a search have the value of one of its ends
    /// until their own is known.
    pub fn jobs(&self) -> impl ExactSizeIterator<Item = Job> {
        (0..self.runs.len()).map(|index| self.job(index))
    }

    /// The key of the run at a position. That of a search has its own once its value is known.
    pub fn key(&self, index: usize) -> String {
        key_text(self.key_of(self.runs[index]))
    }

    fn key_of(&self, ticket: Ticket) -> u64 {
        let keys = &self.sources[ticket.source as usize].probe_keys;
        keys.get(ticket.number as usize).and_then(OnceLock::get).copied().unwrap_or(ticket.key)
    }

    /// Names of the scenarios.
    pub fn scenarios(&self) -> impl Iterator<Item = &str> {
        self.sources.iter().map(|source| source.name.as_str())
    }

    /// The scenario of the run at a position.
    pub fn scenario(&self, index: usize) -> &str {
        &self.sources[self.runs[index].source as usize].name
    }

    /// The key of the reference at a position.
    pub fn reference_key(&self, index: usize) -> String {
        key_text(self.references[index].key)
    }

    /// Position of the reference that a run is compared with.
    pub fn reference_of(&self, index: usize) -> Option<usize> {
        Some(self.runs[index].reference).filter(|r| *r != NONE).map(|r| r as usize)
    }

    /// Folder of the records of the run at a position, below the results folder.
    pub fn folder(&self, index: usize, results: &Path) -> PathBuf {
        results.join(self.scenario(index)).join(self.levels(index).folder(&self.key(index)))
    }

    /// Folders between that of the scenario and that of the run at a position.
    pub(in crate::batch) fn levels(&self, index: usize) -> KeyLevels {
        self.sources[self.runs[index].source as usize].levels()
    }

    /// Position of a run in the plan of all shards, before any filter.
    pub(in crate::batch) fn position_in_whole(&self, index: usize) -> usize {
        let Ticket { source, number, .. } = self.runs[index];
        self.sources[source as usize].first + number as usize
    }

    /// True if the plan is one of several shards.
    pub(in crate::batch) fn is_part(&self) -> bool {
        self.part.as_ref().is_some_and(|part| part.head.of > 1)
    }

    /// The parts of the run at a position in claims.
    pub(in crate::batch) fn claims_of(&self, index: usize) -> impl Iterator<Item = RunClaim> {
        let Ticket { source, number, .. } = self.runs[index];
        self.claims.of_run(source as usize, number as usize)
    }

    /// Restricts the claims to the runs of the plan.
    pub(in crate::batch) fn restrict_claims(&mut self) {
        let selected: HashSet<(usize, usize)> =
            self.runs.iter().map(|ticket| (ticket.source as usize, ticket.number as usize)).collect();
        self.claims = Arc::new(PlanClaims::new(&self.sources, &|source, number| selected.contains(&(source, number))));
    }

    /// True if the seeds of the runs of its scenario differ.
    pub(in crate::batch) fn is_repeated(&self, index: usize) -> bool {
        self.sources[self.runs[index].source as usize].kind.repeated
    }

    /// Number of runs of a scenario file.
    pub fn runs_of(&self, file: &Path) -> usize {
        self.runs.iter().filter(|t| self.sources[t.source as usize].expansion.file().path == *file).count()
    }

    /// Repetitions for timing, over all runs.
    pub fn repetitions(&self) -> usize {
        self.runs.iter().map(|ticket| ticket.repetitions as usize).sum()
    }

    /// Number of repetitions for timing of the run at a position.
    pub(in crate::batch) fn repetitions_of(&self, index: usize) -> u32 {
        self.runs[index].repetitions
    }

    /// Keeps the runs at these ascending positions and the references they need.
    pub(in crate::batch) fn keep(&mut self, positions: &[usize]) {
        let (mut needed, mut known) = (Vec::new(), HashMap::new());
        let mut runs = Vec::with_capacity(positions.len());
        for &position in positions {
            let mut ticket = self.runs[position];
            if ticket.reference != NONE {
                ticket.reference = *known.entry(ticket.reference).or_insert_with_key(|old| {
                    needed.push(self.references[*old as usize]);
                    needed.len() as u32 - 1
                });
            }
            runs.push(ticket);
        }
        (self.runs, self.references) = (runs, needed);
    }

    fn build(&self, index: usize, ticket: Ticket, role: Role) -> Job {
        let source = &self.sources[ticket.source as usize];
        let run = source.expansion.run(ticket.number as usize);
        let run = if role == Role::Reference { run.and_then(|run| run.reference).map(|run| *run) } else { run };
        // Planning built the same run from the same text, values and files without an error.
        let mut run = run.expect("a run that has been checked");
        if let Some(swept) = &self.swept {
            run.parameters = swept.to_vec();
        }
        let mut robots = self.robots.lock().unwrap_or_else(PoisonError::into_inner);
        let (robot, objects) = robots.of_run(&run).expect("robots that have been loaded");
        let key = if role == Role::Reference { key_text(ticket.key) } else { key_text(self.key_of(ticket)) };
        let label =
            if role == Role::Reference { format!("reference {key}") } else { label(&run, source.kind.repeated) };
        Job { index, run, robot, objects, key, label, role, levels: source.levels() }
    }
}

impl std::fmt::Debug for Plan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Plan").field("runs", &self.runs).field("references", &self.references).finish_non_exhaustive()
    }
}

/// A label without the searched key.
pub(in crate::batch) fn cell_label(run: &Run, searched: &[&str], repeated: bool) -> String {
    let mut run = run.clone();
    run.parameters.retain(|(name, _)| !searched.contains(&name.as_str()));
    label(&run, repeated)
}

/// Formats a key, the first 64 bits of a hash, as hexadecimal.
fn key_text(key: u64) -> String {
    format!("{key:016x}")
}

/// One run, ready to execute.
#[derive(Clone, Debug)]
pub struct Job {
    /// Position in the plan, from 0.
    pub index: usize,
    /// The run.
    pub run: Run,
    /// Its robot.
    pub robot: Arc<Robot>,
    /// The models of its objects.
    pub objects: Vec<Arc<Robot>>,
    /// Its key.
    pub key: String,
    /// Label that distinguishes it from the other runs of its file, such as
    /// `contact.method=exact seed=2`; may be empty.
    pub label: String,
    /// Its role in comparisons.
    pub role: Role,
    /// Folders between that of its scenario and its own.
    pub levels: KeyLevels,
}

/// A run's role in comparisons.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// An ordinary run.
    Run {
        /// Position of its reference in the plan.
        reference: Option<usize>,
    },
    /// A run that others are compared with.
    Reference,
}

impl Job {
    /// Folder of its records below the results folder.
    pub fn folder(&self, results: &Path) -> PathBuf {
        self.folder_at(results, self.levels)
    }

    /// Folders that it has as part of a scenario with another number of runs.
    pub(in crate::batch) fn other_folders(&self, results: &Path) -> impl Iterator<Item = PathBuf> {
        KeyLevels::all().filter(|levels| *levels != self.levels).map(move |levels| self.folder_at(results, levels))
    }

    fn folder_at(&self, results: &Path, levels: KeyLevels) -> PathBuf {
        let scenario = results.join(&self.run.name);
        let key = levels.folder(&self.key);
        match self.role {
            Role::Run { .. } => scenario.join(key),
            // One level deeper, so that listing a scenario's runs does not include it.
            Role::Reference => scenario.join(names::REFERENCES).join(key),
        }
    }

    /// Position of its reference in the plan.
    pub fn reference(&self) -> Option<usize> {
        match self.role {
            Role::Run { reference } => reference,
            Role::Reference => None,
        }
    }

    /// True if it writes a log.
    pub(in crate::batch) fn wants_log(&self, options: &Options) -> bool {
        options.log && self.run.scenario.log.rate > 0.0 && self.role != Role::Reference
    }

    /// Number of repetitions for timing.
    pub fn repetitions(&self) -> u32 {
        self.run.scenario.compare.as_ref().and_then(|c| c.timing_repeats).unwrap_or(0)
    }

    /// Swept parameters as in the summary, without `seed`, which has its own column.
    pub fn parameters(&self) -> Vec<(String, ParamValue)> {
        let swept = self.run.parameters.iter().filter(|(name, _)| name != "seed");
        swept.map(|(name, value)| (name.clone(), parameter(value))).collect()
    }
}

/// Inverse of [`parameter`].
fn to_toml(value: &ParamValue) -> toml::Value {
    match value {
        ParamValue::Integer(i) => (*i).into(),
        ParamValue::Number(x) => (*x).into(),
        ParamValue::Flag(b) => (*b).into(),
        ParamValue::Text(s) => s.clone().into(),
    }
}

fn parameter(value: &toml::Value) -> ParamValue {
    match value {
        toml::Value::Integer(i) => ParamValue::Integer(*i),
        toml::Value::Float(x) => ParamValue::Number(*x),
        toml::Value::Boolean(b) => ParamValue::Flag(*b),
        toml::Value::String(s) => ParamValue::Text(s.clone()),
        other => ParamValue::Text(other.to_string()),
    }
}

fn label(run: &Run, repeated: bool) -> String {
    let named = run.parameters.iter().filter(|(name, _)| !is_truth(name));
    let mut parts: Vec<String> = named.map(|(name, value)| format!("{name}={}", parameter(value))).collect();
    if repeated && !run.parameters.iter().any(|(name, _)| name == "seed") {
        parts.push(format!("seed={}", run.scenario.seed));
    }
    parts.join(" ")
}
