//! From scenario files to jobs, everything checked.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::robots::Robots;
use super::{Finding, Findings, keys};
use crate::record::{ParamValue, is_truth};
use crate::robot::{Robot, RobotError};
use crate::scenario::{self, Run, ScenarioFile};
use crate::sim::build::setup;

/// Errors after which checking gives up.
const MAX_ERRORS: usize = 50;

/// Files of the results, beside which the folder of each scenario stands.
const RESERVED: [&str; 4] = ["summary.csv", "summary.parquet", "runs.jsonl", "report.html"];

/// What will be run, in order.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The runs.
    pub jobs: Vec<Job>,
    /// The runs that some of these are compared with, each once, in the order in which they are first needed.
    pub references: Vec<Job>,
    /// The scenario files they come from.
    pub files: Vec<PathBuf>,
}

impl Plan {
    /// Repetitions for timing, over all runs.
    pub fn repetitions(&self) -> usize {
        self.jobs.iter().map(|job| job.repetitions() as usize).sum()
    }
}

/// One run that is ready to go.
#[derive(Clone, Debug)]
pub struct Job {
    /// Position in the plan, from 0.
    pub index: usize,
    /// The run.
    pub run: Run,
    /// Its robot.
    pub robot: Arc<Robot>,
    /// Its key.
    pub key: String,
    /// What distinguishes it from the other runs of its file, such as `contact.method=exact seed=2`; may be empty.
    pub label: String,
    /// Its part in comparisons.
    pub role: Role,
}

/// A run's part in comparisons.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// A run of its own.
    Run {
        /// Position in [`Plan::references`] of the run that it is compared with.
        reference: Option<usize>,
    },
    /// A run that others are compared with.
    Reference,
}

impl Job {
    /// The folder of its records, below that of the results.
    pub fn folder(&self, results: &Path) -> PathBuf {
        let scenario = results.join(&self.run.name);
        match self.role {
            Role::Run { .. } => scenario.join(&self.key),
            // One level deeper: who lists the runs of a scenario does not find it.
            Role::Reference => scenario.join("references").join(&self.key),
        }
    }

    /// Position in [`Plan::references`] of the run that it is compared with.
    pub fn reference(&self) -> Option<usize> {
        match self.role {
            Role::Run { reference } => reference,
            Role::Reference => None,
        }
    }

    /// How often it is repeated to time it.
    pub fn repetitions(&self) -> u32 {
        self.run.scenario.compare.as_ref().and_then(|c| c.timing_repeats).unwrap_or(0)
    }

    /// Swept parameters as the summary holds them. `seed` has a column of its own.
    pub fn parameters(&self) -> Vec<(String, ParamValue)> {
        let swept = self.run.parameters.iter().filter(|(name, _)| name != "seed");
        swept.map(|(name, value)| (name.clone(), parameter(value))).collect()
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

/// Loads scenario files and robots, expands sweeps and builds every run's setup once to see that it can be built.
///
/// `overrides` are values under dotted paths that replace those of every file. No more than `max_runs` runs are made.
///
/// # Errors
/// All errors found, with what else there is to say; nothing has been written. `Ok` holds warnings and notes.
pub fn prepare(
    files: &[PathBuf],
    overrides: &[(String, toml::Value)],
    max_runs: usize,
) -> Result<(Plan, Findings), Findings> {
    let mut planner = Planner { max_runs, ..Planner::default() };
    let files = distinct(files);
    for path in &files {
        planner.add(path, overrides);
        if planner.findings.errors() >= MAX_ERRORS {
            break;
        }
    }
    let Planner { jobs, references, findings, .. } = planner;
    if findings.errors() > 0 { Err(findings) } else { Ok((Plan { jobs, references, files }, findings)) }
}

/// The same for one file whose text is at hand, such as that of a record.
///
/// # Errors
/// See [`prepare`].
pub fn prepare_file(file: &ScenarioFile) -> Result<(Plan, Findings), Findings> {
    let mut planner = Planner { max_runs: scenario::DEFAULT_MAX_RUNS, ..Planner::default() };
    planner.add_file(file, &[]);
    let Planner { jobs, references, findings, .. } = planner;
    if findings.errors() > 0 {
        Err(findings)
    } else {
        Ok((Plan { jobs, references, files: vec![file.path.clone()] }, findings))
    }
}

/// A file named twice, by itself and by its folder, is one file.
fn distinct(files: &[PathBuf]) -> Vec<PathBuf> {
    let mut seen = BTreeSet::new();
    let identity = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
    files.iter().filter(|path| seen.insert(identity(path))).cloned().collect()
}

#[derive(Default)]
struct Planner {
    robots: Robots,
    jobs: Vec<Job>,
    references: Vec<Job>,
    findings: Findings,
    max_runs: usize,
    /// Scenario names with their files: a name is a folder of the results.
    names: HashMap<String, PathBuf>,
    /// Folders of the results that are taken.
    taken: HashMap<(String, String), usize>,
    /// References by key, with the shape of their robots.
    known: HashMap<String, (usize, Shape)>,
}

/// What of two robots must be equal for their runs to be compared: numbers of joints and of soles.
type Shape = (usize, usize);

impl Planner {
    fn add(&mut self, path: &Path, overrides: &[(String, toml::Value)]) {
        match scenario::load(path) {
            Ok(file) => self.add_file(&file, overrides),
            Err(diagnostics) => self.findings.extend(diagnostics),
        }
    }

    fn add_file(&mut self, file: &ScenarioFile, overrides: &[(String, toml::Value)]) {
        match file.expand_at_most(overrides, self.max_runs) {
            Ok(runs) => self.add_runs(runs, file),
            Err(diagnostics) => self.findings.extend(diagnostics),
        }
    }

    fn add_runs(&mut self, runs: Vec<Run>, file: &ScenarioFile) {
        let name = file.name();
        if let Some(other) = self.names.insert(name.clone(), file.path.clone()) {
            let (a, b) = (other.display(), file.path.display());
            let message = format!("{a} and {b} are both scenario `{name}`: their results would share one folder");
            return self.findings.push(Finding::Plan(message));
        }
        if RESERVED.contains(&name.as_str()) {
            let message =
                format!("{}: `{name}` is a file of the results and no name for a folder", file.path.display());
            return self.findings.push(Finding::Plan(message));
        }
        let total = self.jobs.len() + runs.len();
        if total > self.max_runs {
            let (path, max) = (file.path.display(), self.max_runs);
            let message =
                format!("with {path} there are {total} runs, {max} are allowed; `--max-runs` raises the limit");
            return self.findings.push(Finding::Plan(message));
        }
        if let Some(run) = runs.first()
            && run.parameters.iter().any(|(name, _)| name == "integrator")
        {
            let help = Some("sweep `integrator.method`".into());
            let message = "`integrator` as a whole cannot be swept: the summary has a column of that name";
            let error = run.error_at("integrator", message, help);
            return self.findings.push(Finding::Scenario(Box::new(error)));
        }
        let first_seed = runs.first().map(|r| r.scenario.seed);
        let repeated = runs.iter().any(|r| Some(r.scenario.seed) != first_seed);
        for run in runs {
            if self.findings.errors() >= MAX_ERRORS {
                return;
            }
            self.add_run(run, repeated);
        }
    }

    fn add_run(&mut self, mut run: Run, repeated: bool) {
        self.findings.extend(std::mem::take(&mut run.warnings));
        let Some(robot) = self.robot(&run) else { return };
        let Some(shape) = self.build(&run, &robot) else { return };
        let Some(key) = self.key(&run, &robot) else { return };
        let reference = match run.reference.take() {
            Some(reference) => {
                let Some(index) = self.add_reference(&run, *reference, shape) else { return };
                Some(index)
            }
            None => None,
        };
        let index = self.jobs.len();
        if let Some(twin) = self.taken.insert((run.name.clone(), key.clone()), index) {
            let numbers = (self.jobs[twin].run.index + 1, run.index + 1);
            let message = format!("runs {} and {} of {} are the same", numbers.0, numbers.1, run.file.display());
            return self.findings.push(Finding::Plan(message));
        }
        let label = label(&run, repeated);
        self.jobs.push(Job { index, run, robot, key, label, role: Role::Run { reference } });
    }

    /// The reference of a run, made when no other run has it already.
    fn add_reference(&mut self, of: &Run, run: Run, shape: Shape) -> Option<usize> {
        let robot = self.robot(&run)?;
        let key = self.key(&run, &robot)?;
        let (index, other) = match self.known.get(&key) {
            Some(known) => *known,
            None => {
                let known = (self.references.len(), self.build(&run, &robot)?);
                self.known.insert(key.clone(), known);
                let label = format!("reference {key}");
                self.references.push(Job { index: known.0, run, robot, key, label, role: Role::Reference });
                known
            }
        };
        if other != shape {
            let message = format!(
                "the reference's robot has {} joints and {} soles, the run's {} and {}: they cannot be compared",
                other.0, other.1, shape.0, shape.1
            );
            let error = of.error_at("compare.reference", message, None);
            self.findings.push(Finding::Scenario(Box::new(error)));
            return None;
        }
        Some(index)
    }

    /// Builds a run's setup to see that it can be built.
    fn build(&mut self, run: &Run, robot: &Robot) -> Option<Shape> {
        match setup(run, robot) {
            Ok(setup) => Some((setup.model.nj(), setup.model.soles.len())),
            Err(errors) => {
                self.findings.extend(errors);
                None
            }
        }
    }

    fn key(&mut self, run: &Run, robot: &Robot) -> Option<String> {
        let key = keys::of(run, robot);
        key.map_err(|message| self.findings.push(Finding::Plan(format!("{}: {message}", run.file.display())))).ok()
    }

    fn robot(&mut self, run: &Run) -> Option<Arc<Robot>> {
        let path = run.resolve(&run.scenario.robot.model);
        let (robot, new) = self.robots.get(&path, &run.scenario.robot);
        match robot {
            Ok(robot) => {
                if new {
                    robot.notices.iter().for_each(|n| self.findings.push(Finding::Notice(n.clone())));
                }
                Some(robot)
            }
            // The mistake is in the scenario: there is no such file.
            Err(error @ RobotError::Read { .. }) => {
                let shown = run.error_at("robot.model", error.to_string(), None);
                self.findings.push(Finding::Scenario(Box::new(shown)));
                None
            }
            Err(error) => {
                if new {
                    let named_at = run.error_at("robot.model", "", None).location();
                    self.findings.push(Finding::Robot { error: Box::new(error), named_at });
                }
                None
            }
        }
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
