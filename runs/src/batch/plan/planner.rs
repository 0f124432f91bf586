//! Turns scenario files into a checked plan.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;

use rayon::prelude::*;

use crate::batch::plan::batch_plan::{NONE, Plan, Source, Ticket, Traits};
use crate::batch::plan::finding::MAX_ERRORS;
use crate::batch::plan::plan_claims::PlanClaims;
use crate::batch::plan::robot_cache::Robots;
use crate::batch::plan::run_check::{CheckedRun, CheckedRuns, FileIdentity, RunCheck, RunFinding};
use crate::batch::{Finding, Findings, Shard};
use crate::files::names::BATCH_FILES;
use crate::scenario::{self, Diagnostic, Expansion, ExpansionCheck, ScenarioFile};

/// Greatest number of runs of a file that each shard checks; of larger ones it checks its own runs.
const MAX_CHECKED_BY_ALL: usize = 100_000;

/// Greatest number of runs that a thread checks at a time.
const CHUNK: usize = 1_000;

/// Number of chunks in memory at a time.
const CHUNKS: usize = 64;

/// Wall-clock time after which the scripts of a run must be ready.
pub const DEFAULT_TIME_LIMIT: Duration = Duration::from_secs(60);

/// Loads scenario files and robots, expands every sweep and checks each run's setup by building it.
///
/// `overrides` replace values of every file by dotted path. The plan has at most `max_runs` runs.
///
/// # Errors
/// The errors found, with warnings and notes; nothing is written. `Ok` has warnings and notes.
pub fn prepare(
    files: &[PathBuf],
    overrides: &[(String, toml::Value)],
    max_runs: usize,
) -> Result<(Plan, Findings), Findings> {
    prepare_within(files, overrides, max_runs, DEFAULT_TIME_LIMIT, None)
}

/// Like [`prepare`]; the scripts of a run must be ready within `time_limit` of wall-clock time. With
/// a shard, the plan has its runs only; other runs of large files are not checked.
///
/// # Errors
/// See [`prepare`].
pub fn prepare_within(
    files: &[PathBuf],
    overrides: &[(String, toml::Value)],
    max_runs: usize,
    time_limit: Duration,
    shard: Option<Shard>,
) -> Result<(Plan, Findings), Findings> {
    let mut planner = Planner { max_runs, time_limit, shard, ..Planner::default() };
    let files = distinct(files);
    for path in &files {
        planner.add(path, overrides);
        if planner.findings.errors() >= MAX_ERRORS {
            break;
        }
    }
    planner.plan(files)
}

/// Values by dotted path that replace those of a file.
pub type Overrides = Vec<(String, toml::Value)>;

/// Like [`prepare`] for files that are loaded already, such as texts in memory, each with overrides of
/// its own.
///
/// # Errors
/// See [`prepare`].
pub fn prepare_loaded<'a>(
    files: impl IntoIterator<Item = (&'a ScenarioFile, &'a Overrides)>,
    max_runs: usize,
) -> Result<(Plan, Findings), Findings> {
    let mut planner = Planner { max_runs, time_limit: DEFAULT_TIME_LIMIT, ..Planner::default() };
    let mut paths = Vec::new();
    for (file, overrides) in files {
        planner.add_file(file, overrides);
        paths.push(file.path.clone());
        if planner.findings.errors() >= MAX_ERRORS {
            break;
        }
    }
    planner.plan(paths)
}

/// Removes duplicates: a file may be named directly and through its folder.
fn distinct(files: &[PathBuf]) -> Vec<PathBuf> {
    let mut seen = BTreeSet::new();
    let identity = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
    files.iter().filter(|path| seen.insert(identity(path))).cloned().collect()
}

#[derive(Default)]
struct Planner {
    robots: Mutex<Robots>,
    runs: Vec<Ticket>,
    sources: Vec<Arc<Source>>,
    findings: Findings,
    max_runs: usize,
    /// Wall-clock limit of building one setup.
    time_limit: Duration,
    /// The shard to plan; none for all runs.
    shard: Option<Shard>,
    /// Runs of all shards.
    total: usize,
    /// Files by scenario name; a name is also a folder of the results.
    names: HashMap<String, PathBuf>,
    /// Files whose findings are reported.
    reported: HashSet<FileIdentity>,
    /// Hashes of files that runs use, by their names.
    used: BTreeMap<String, String>,
    /// References so far.
    references: References,
}

/// Reference runs, each once, in the order of first use.
#[derive(Clone, Default)]
struct References {
    tickets: Vec<Ticket>,
    /// Their positions by their keys.
    known: HashMap<u64, u32>,
}

impl References {
    /// Position of a reference, which is added unless it is known.
    fn position(&mut self, ticket: Ticket) -> u32 {
        *self.known.entry(ticket.key).or_insert_with(|| {
            self.tickets.push(ticket);
            self.tickets.len() as u32 - 1
        })
    }
}

/// The runs of a file, with what was found about them.
struct FileRuns<'a> {
    expansion: &'a Expansion,
    name: String,
    cells: ExpansionCheck<'a>,
    found: Vec<RunFinding>,
    runs: Vec<Ticket>,
    references: References,
    /// Position of the file among the sources.
    source: u32,
    /// Number of the first run of each combination of values, by its key.
    combinations: HashMap<u64, usize>,
    /// First seed of the runs, and whether others differ.
    seed: Option<(u64, bool)>,
    remote: bool,
    /// Number of errors that concern runs.
    errors: Findings,
}

impl Planner {
    fn plan(self, files: Vec<PathBuf>) -> Result<(Plan, Findings), Findings> {
        let Planner { robots, runs, references, sources, findings, used, .. } = self;
        if findings.errors() > 0 {
            return Err(findings);
        }
        let robots = Arc::new(Mutex::new(robots.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)));
        let references = references.tickets;
        let claims = Arc::new(PlanClaims::of_all(&sources));
        let mut plan =
            Plan { runs, references, sources, robots, files, part: None, swept: None, claims, filter: None, used };
        if let Some(shard) = self.shard {
            plan.set_part(shard, self.total);
        }
        Ok((plan, findings))
    }

    fn add(&mut self, path: &Path, overrides: &[(String, toml::Value)]) {
        match scenario::load(path) {
            Ok(file) => self.add_file(&file, overrides),
            Err(diagnostics) => self.findings.extend(diagnostics),
        }
    }

    fn add_file(&mut self, file: &ScenarioFile, overrides: &[(String, toml::Value)]) {
        let expansion = match file.expansion(overrides, self.max_runs.min(scenario::MAX_BATCH_RUNS)) {
            Ok(expansion) => expansion,
            Err(diagnostics) => return self.findings.extend(diagnostics),
        };
        let FileRuns { cells, found, runs, references, seed, remote, .. } = self.check(&expansion);
        match cells.finish() {
            // Errors of single runs follow from those of values.
            Err(diagnostics) => return self.findings.extend(diagnostics),
            Ok((warnings, unused)) => {
                self.findings.extend(warnings);
                self.findings.extend(expansion.claim_warnings().clone());
                // In a part, other runs may use what its runs do not.
                if self.checks_all(&expansion) || !expansion.sweeps("contact.method") {
                    self.findings.extend(unused);
                }
            }
        }
        if !self.accepts(&expansion) {
            return;
        }
        for found in found {
            self.add_finding(found);
        }
        let repeated = expansion.repetitions().min(expansion.runs()) > 1 || seed.is_some_and(|(_, differ)| differ);
        self.add_runs(runs, references);
        let first = self.total;
        self.total += expansion.runs();
        let (name, kind) = (expansion.file().name(), Traits { repeated, remote });
        let probes = if expansion.search().is_some() { expansion.runs() } else { 0 };
        let probe_keys = (0..probes).map(|_| OnceLock::new()).collect();
        self.sources.push(Arc::new(Source { expansion, name, kind, first, probe_keys }));
    }

    /// True if all runs of a file are checked, those of other shards too.
    fn checks_all(&self, expansion: &Expansion) -> bool {
        self.shard.is_none() || expansion.runs() <= MAX_CHECKED_BY_ALL
    }

    /// Checks the runs of a file, and keeps those of the shard.
    fn check<'a>(&self, expansion: &'a Expansion) -> FileRuns<'a> {
        let mut file = FileRuns::new(expansion, self.sources.len() as u32);
        let name = file.name.clone();
        let count = expansion.runs();
        let mut numbers: Box<dyn Iterator<Item = usize>> = match self.shard {
            Some(shard) if !self.checks_all(expansion) && expansion.search().is_none() => {
                Box::new(shard.numbers(&name, count))
            }
            _ => Box::new(expansion.checked_numbers()),
        };
        let check = RunCheck { expansion, robots: &self.robots, time_limit: self.time_limit };
        let size = (count / CHUNKS).clamp(1, CHUNK);
        loop {
            let some: Vec<u32> = numbers.by_ref().take(size * CHUNKS).map(|number| number as u32).collect();
            if some.is_empty() {
                break;
            }
            // A single chunk needs no other thread.
            let checked: Vec<CheckedRuns> = match some.len() > size {
                true => some.par_chunks(size).map(|chunk| check.check(chunk)).collect(),
                false => vec![check.check(&some)],
            };
            for runs in checked {
                let kept =
                    |run: &CheckedRun| self.shard.is_none_or(|shard| shard.contains(&name, expansion.unit(run.number)));
                file.add(runs, kept, self.findings.errors());
            }
            if file.cells.is_full() {
                break;
            }
        }
        file
    }

    /// False, with an error, if a file conflicts with other files or the limits.
    fn accepts(&mut self, expansion: &Expansion) -> bool {
        let file = expansion.file();
        let name = file.name();
        let total = self.total + expansion.runs();
        let refused = if let Some(other) = self.names.insert(name.clone(), file.path.clone()) {
            let (a, b) = (other.display(), file.path.display());
            let message = format!("{a} and {b} are both scenario `{name}`: their results would share one folder");
            (message, "rename one of them, or run each with an --output of its own")
        } else if BATCH_FILES.contains(&name.as_str()) {
            let message = format!("`{name}` is a file of the results and cannot be the name of a folder");
            (message, "rename the scenario")
        } else if total > self.max_runs {
            let message = format!("with this file the batch has {total} runs, {} are allowed", self.max_runs);
            (message, "`--max-runs` raises the limit")
        } else if let Some(run) = expansion.run(0).filter(|_| expansion.sweeps("integrator"))
            && run.parameters.iter().any(|(name, _)| name == "integrator")
        {
            let help = Some("sweep `integrator.method`".into());
            let message = "`integrator` as a whole cannot be swept: the summary has a column of that name";
            let error = run.error_at("integrator", message, help);
            self.findings.push(Finding::Scenario(Box::new(error)));
            return false;
        } else {
            return true;
        };
        let wrong = Diagnostic::whole_file(file.path.display().to_string(), refused.0);
        self.findings.push(Finding::Scenario(Box::new(wrong.with_help(refused.1))));
        false
    }

    fn add_finding(&mut self, found: RunFinding) {
        match found {
            RunFinding::Finding(finding) => self.findings.push(finding),
            RunFinding::OfFile(identity, findings) => {
                if self.reported.insert(identity) {
                    findings.into_iter().for_each(|finding| self.findings.push(finding));
                }
            }
            RunFinding::Used(name, hash) => _ = self.used.insert(name, hash),
        }
    }

    /// Adds the runs of a file with their references.
    fn add_runs(&mut self, mut runs: Vec<Ticket>, references: References) {
        let positions: Vec<u32> =
            references.tickets.into_iter().map(|ticket| self.references.position(ticket)).collect();
        for run in runs.iter_mut().filter(|run| run.reference != NONE) {
            run.reference = positions[run.reference as usize];
        }
        // A large file is mostly the only one.
        if self.runs.is_empty() {
            self.runs = runs;
        } else {
            self.runs.append(&mut runs);
        }
    }
}

impl<'a> FileRuns<'a> {
    fn new(expansion: &'a Expansion, source: u32) -> Self {
        FileRuns {
            expansion,
            name: expansion.file().name(),
            cells: ExpansionCheck::new(expansion),
            found: Vec::new(),
            runs: Vec::new(),
            references: References::default(),
            source,
            combinations: HashMap::new(),
            seed: None,
            remote: false,
            errors: Findings::default(),
        }
    }

    /// Adds the runs that follow. `earlier` is the number of errors of earlier files.
    fn add(&mut self, checked: CheckedRuns, kept: impl Fn(&CheckedRun) -> bool, earlier: usize) {
        self.cells.add(checked.cells);
        self.remote |= checked.remote;
        if let Some((seed, differ)) = checked.seeds {
            let (first, differed) = self.seed.unwrap_or((seed, false));
            self.seed = Some((first, differed || differ || seed != first));
        }
        // Keys name folders of the results.
        let twins = checked.combinations.into_iter().filter_map(|(key, number)| {
            let other = *self.combinations.entry(key).or_insert(number);
            (other != number).then_some((other, number))
        });
        let file = self.expansion.file().path.display();
        let same =
            |(a, b): (usize, usize)| Finding::Plan(format!("runs {} and {} of {file} are the same", a + 1, b + 1));
        let twins: Vec<_> = twins.take(MAX_ERRORS).map(same).map(RunFinding::Finding).collect();
        for found in checked.found.into_iter().chain(twins) {
            if earlier + self.errors.errors() >= MAX_ERRORS {
                break;
            }
            let findings = match &found {
                RunFinding::Finding(finding) => std::slice::from_ref(finding),
                RunFinding::OfFile(_, findings) => findings.as_slice(),
                RunFinding::Used(..) => &[],
            };
            findings.iter().for_each(|finding| self.errors.push(finding.clone()));
            self.found.push(found);
        }
        for run in checked.runs.into_iter().filter(kept) {
            let (source, number) = (self.source, run.number as u32);
            let ticket = |key, reference, repetitions| Ticket { key, source, number, reference, repetitions };
            let reference = run.reference.map_or(NONE, |key| self.references.position(ticket(key, NONE, 0)));
            self.runs.push(ticket(run.key, reference, run.timing));
            if let Some(search) = self.expansion.search() {
                // The first run of a cell stands for all.
                let slots = search.slots_per_cell() as u32;
                if let Some(first) = self.runs.pop().filter(|_| number.is_multiple_of(slots)) {
                    self.runs.extend((0..slots).map(|slot| Ticket { number: number + slot, ..first }));
                }
            }
        }
    }
}
