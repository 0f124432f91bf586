//! Turns scenario files into a checked plan.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::assemble::{log_size, setup};
use crate::batch::plan::batch_plan::{NONE, Plan, Source, Ticket, Traits};
use crate::batch::plan::robot_cache::Robots;
use crate::batch::plan::run_key;
use crate::batch::{Finding, Findings};
use crate::files::input;
use crate::files::names::BATCH_FILES;
use crate::robot::{Robot, RobotError};
use crate::scenario::{self, Diagnostic, Diagnostics, Expansion, Run, ScenarioFile, Severity};
use crate::script::time_limited;

/// Number of errors after which checking stops.
const MAX_ERRORS: usize = 50;

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
    prepare_within(files, overrides, max_runs, DEFAULT_TIME_LIMIT)
}

/// Like [`prepare`]; the scripts of a run must be ready within `time_limit` of wall-clock time.
///
/// # Errors
/// See [`prepare`].
pub fn prepare_within(
    files: &[PathBuf],
    overrides: &[(String, toml::Value)],
    max_runs: usize,
    time_limit: Duration,
) -> Result<(Plan, Findings), Findings> {
    let mut planner = Planner { max_runs, time_limit, ..Planner::default() };
    let files = distinct(files);
    for path in &files {
        planner.add(path, overrides);
        if planner.findings.errors() >= MAX_ERRORS {
            break;
        }
    }
    planner.plan(files)
}

/// Like [`prepare`] for one file whose text is in memory, such as that of a record.
///
/// # Errors
/// See [`prepare`].
pub fn prepare_file(file: &ScenarioFile) -> Result<(Plan, Findings), Findings> {
    let (max_runs, time_limit) = (scenario::DEFAULT_MAX_RUNS, DEFAULT_TIME_LIMIT);
    let mut planner = Planner { max_runs, time_limit, ..Planner::default() };
    planner.add_file(file, &[]);
    planner.plan(vec![file.path.clone()])
}

/// Removes duplicates: a file may be named directly and through its folder.
fn distinct(files: &[PathBuf]) -> Vec<PathBuf> {
    let mut seen = BTreeSet::new();
    let identity = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
    files.iter().filter(|path| seen.insert(identity(path))).cloned().collect()
}

#[derive(Default)]
struct Planner {
    robots: Robots,
    runs: Vec<Ticket>,
    references: Vec<Ticket>,
    sources: Vec<Arc<Source>>,
    findings: Findings,
    max_runs: usize,
    /// Wall-clock limit of building one setup.
    time_limit: Duration,
    /// Files by scenario name; a name is also a folder of the results.
    names: HashMap<String, PathBuf>,
    /// Files already checked for symbolic links.
    link_checked: HashSet<PathBuf>,
    /// References by key, with the shape of their robots.
    known: HashMap<u64, (u32, Shape)>,
}

/// Numbers of joints and soles, which must be equal for two runs to be compared.
type Shape = (usize, usize);

impl Planner {
    fn plan(self, files: Vec<PathBuf>) -> Result<(Plan, Findings), Findings> {
        let Planner { robots, runs, references, sources, findings, .. } = self;
        if findings.errors() > 0 {
            return Err(findings);
        }
        let robots = Arc::new(Mutex::new(robots));
        Ok((Plan { runs, references, sources, robots, files, part: None, swept: None }, findings))
    }

    fn add(&mut self, path: &Path, overrides: &[(String, toml::Value)]) {
        match scenario::load(path) {
            Ok(file) => self.add_file(&file, overrides),
            Err(diagnostics) => self.findings.extend(diagnostics),
        }
    }

    fn add_file(&mut self, file: &ScenarioFile, overrides: &[(String, toml::Value)]) {
        let max_runs = self.max_runs.min(scenario::MAX_BATCH_RUNS);
        match file.expansion(overrides, max_runs).and_then(|e| self.check(e)) {
            Ok((expansion, first, kind)) => self.add_runs(expansion, &first, kind),
            Err(diagnostics) => self.findings.extend(diagnostics),
        }
    }

    /// Expands all runs of a file and reports all errors together; returns its first run and
    /// traits.
    fn check(&mut self, expansion: Expansion) -> Result<(Expansion, Option<Run>, Traits), Diagnostics> {
        let (mut first, mut kind): (Option<Run>, Traits) = (None, Traits::default());
        let mut warnings = Diagnostics::default();
        let unused = expansion.check(&mut |mut run| {
            warnings.0.append(&mut run.warnings.0);
            kind.remote |= run.scenario.robot.backend.is_some();
            match &first {
                Some(first) => kind.repeated |= first.scenario.seed != run.scenario.seed,
                None => first = Some(run),
            }
        })?;
        self.findings.extend(warnings);
        self.findings.extend(unused);
        Ok((expansion, first, kind))
    }

    fn add_runs(&mut self, expansion: Expansion, first: &Option<Run>, kind: Traits) {
        let file = expansion.file();
        let name = file.name();
        if let Some(other) = self.names.insert(name.clone(), file.path.clone()) {
            let (a, b) = (other.display(), file.path.display());
            let message = format!("{a} and {b} are both scenario `{name}`: their results would share one folder");
            let help = "rename one of them, or run each with an --output of its own";
            return self.refuse_file(file, message, help);
        }
        if BATCH_FILES.contains(&name.as_str()) {
            let message = format!("`{name}` is a file of the results and cannot be the name of a folder");
            return self.refuse_file(file, message, "rename the scenario");
        }
        let total = self.runs.len() + expansion.runs();
        if total > self.max_runs {
            let message = format!("with this file the batch has {total} runs, {} are allowed", self.max_runs);
            return self.refuse_file(file, message, "`--max-runs` raises the limit");
        }
        if let Some(run) = first
            && run.parameters.iter().any(|(name, _)| name == "integrator")
        {
            let help = Some("sweep `integrator.method`".into());
            let message = "`integrator` as a whole cannot be swept: the summary has a column of that name";
            let error = run.error_at("integrator", message, help);
            return self.findings.push(Finding::Scenario(Box::new(error)));
        }
        // Keys name folders of the results.
        let mut known_keys = HashMap::new();
        for number in 0..expansion.runs() {
            if self.findings.errors() >= MAX_ERRORS {
                return;
            }
            // `check` expanded it without an error.
            if let Some(run) = expansion.run(number) {
                self.add_run(run, &mut known_keys);
            }
        }
        self.sources.push(Arc::new(Source { expansion, name, kind }));
    }

    /// Reports a conflict of a valid scenario with other files or the limits.
    fn refuse_file(&mut self, file: &ScenarioFile, message: String, help: &str) {
        let wrong = Diagnostic::whole_file(file.path.display().to_string(), message);
        self.findings.push(Finding::Scenario(Box::new(wrong.with_help(help))));
    }

    fn add_run(&mut self, mut run: Run, known_keys: &mut HashMap<u64, usize>) {
        self.warn_of_links(&run);
        let Some(robot) = self.robot(&run) else { return };
        let Some(shape) = self.build(&run, &robot) else { return };
        let Some(key) = self.key(&run, &robot) else { return };
        let reference = match run.reference.take() {
            Some(reference) => {
                let Some(index) = self.add_reference(&run, *reference, shape) else { return };
                index
            }
            None => NONE,
        };
        if let Some(twin) = known_keys.insert(key, run.index) {
            let message = format!("runs {} and {} of {} are the same", twin + 1, run.index + 1, run.file.display());
            return self.findings.push(Finding::Plan(message));
        }
        let repetitions = run.scenario.compare.as_ref().and_then(|c| c.timing_repeats).unwrap_or(0);
        self.runs.push(Ticket { repetitions, ..self.ticket(key, &run, reference) });
    }

    /// Ticket for a run of the current file.
    fn ticket(&self, key: u64, run: &Run, reference: u32) -> Ticket {
        Ticket { key, source: self.sources.len() as u32, number: run.index as u32, reference, repetitions: 0 }
    }

    /// Position of a run's reference, added unless another run has it already.
    fn add_reference(&mut self, of: &Run, run: Run, shape: Shape) -> Option<u32> {
        let robot = self.robot(&run)?;
        let key = self.key(&run, &robot)?;
        let (index, other) = match self.known.get(&key) {
            Some(known) => *known,
            None => {
                let known = (self.references.len() as u32, self.build(&run, &robot)?);
                self.known.insert(key, known);
                self.references.push(self.ticket(key, of, NONE));
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

    /// Builds a run's setup to check it.
    fn build(&mut self, run: &Run, robot: &Robot) -> Option<Shape> {
        match time_limited(self.time_limit, || setup(run, robot)) {
            Ok(setup) => {
                if let Some(warning) = log_size::warning(run, &setup) {
                    self.findings.push(Finding::Scenario(Box::new(warning)));
                }
                Some((setup.model.nj(), setup.model.soles.len()))
            }
            Err(errors) => {
                self.findings.extend(errors);
                None
            }
        }
    }

    fn key(&mut self, run: &Run, robot: &Robot) -> Option<u64> {
        let key = run_key::of(run, robot)
            .map_err(|e| format!("the scenario cannot be written out: {e}"))
            .and_then(|key| u64::from_str_radix(&key, 16).map_err(|e| format!("its key {key} is not a hash: {e}")));
        key.map_err(|message| self.findings.push(Finding::Plan(format!("{}: {message}", run.file.display())))).ok()
    }

    /// Warns about symbolic links that redirect the files a run names.
    fn warn_of_links(&mut self, run: &Run) {
        let home = run.file.parent().unwrap_or(Path::new(""));
        let robot = ("robot.model", run.resolve(&run.scenario.robot.model));
        let inputs = run.inputs.iter().map(|input| (input.key.as_str(), input.path.clone()));
        for (key, path) in std::iter::once(robot).chain(inputs) {
            if !self.link_checked.insert(path.clone()) {
                continue;
            }
            if let Some(real) = input::outside_target(home, &path) {
                let message = format!("a symbolic link leads elsewhere: {} is {}", path.display(), real.display());
                let mut warning = run.error_at(key, message, None);
                warning.severity = Severity::Warning;
                self.findings.push(Finding::Scenario(Box::new(warning)));
            }
        }
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
            // The scenario names an unreadable file, so the error points into the scenario.
            Err(error @ RobotError::Read { .. }) => {
                let error = run.error_at("robot.model", error.to_string(), None);
                self.findings.push(Finding::Scenario(Box::new(error)));
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
