//! Checks runs of one file: each combination of swept values is read and set up once, each run gets
//! its key. Chunks of runs are checked in parallel; the planner adds them in order.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::assemble::{log_size, setup_with};
use crate::batch::plan::finding::MAX_ERRORS;
use crate::batch::plan::robot_cache::Robots as RobotCache;
use crate::batch::plan::run_key::{LastFiles, RunKeys};
use crate::batch::{Finding, Findings};
use crate::input;
use crate::robot::{Robot, RobotError};
use crate::scenario::{CheckedCell, CheckedCells, Expansion, ForceSpec, InertiaSpec, Run, Severity, TaskSpec};
use crate::script::time_limited;

/// Numbers of joints and soles, and the numbers of joints of the objects, which must be equal for two runs
/// to be compared.
type Shape = ([usize; 2], Vec<usize>);

/// The robot of a run and the models of its objects.
type Robots = (Arc<Robot>, Vec<Arc<Robot>>);

/// Checks runs of a file.
pub(super) struct RunCheck<'a> {
    pub expansion: &'a Expansion,
    pub robots: &'a Mutex<RobotCache>,
    /// Wall-clock limit of building one setup.
    pub time_limit: Duration,
}

/// What was found about some runs.
#[derive(Default)]
pub(super) struct CheckedRuns {
    /// Findings about values.
    pub cells: CheckedCells,
    /// Findings about runs that can be read, in their order.
    pub found: Vec<RunFinding>,
    pub runs: Vec<CheckedRun>,
    /// Combinations of values: the key and number of the first run of each.
    pub combinations: Vec<(u64, usize)>,
    /// First seeds of the combinations: one, and whether there are others.
    pub seeds: Option<(u64, bool)>,
    /// True if a run drives a remote robot.
    pub remote: bool,
}

/// A run without errors.
pub(super) struct CheckedRun {
    pub number: usize,
    pub key: u64,
    pub reference: Option<u64>,
    /// Number of repetitions for timing.
    pub timing: u32,
}

/// A finding about a run.
pub(super) enum RunFinding {
    Finding(Finding),
    /// Findings about a file, which are reported once.
    OfFile(FileIdentity, Vec<Finding>),
    /// A file that runs use, as they name it, and a hash of its bytes.
    Used(String, String),
}

/// What findings about a file are about.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) enum FileIdentity {
    /// Its path.
    Path(PathBuf),
    /// The robot at a path under an inertia policy.
    Robot(PathBuf, Option<InertiaSpec>),
}

impl RunCheck<'_> {
    /// Checks runs, given by their ascending numbers.
    pub fn check(&self, numbers: &[u32]) -> CheckedRuns {
        let mut chunk = Chunk {
            check: self,
            checked: Default::default(),
            robots: Default::default(),
            paths: Default::default(),
            errors: Default::default(),
            files: Default::default(),
            references: Default::default(),
        };
        let repeat = self.expansion.repetitions();
        for runs in numbers.chunk_by(|a, b| *a as usize / repeat == *b as usize / repeat) {
            let Some(cell) = chunk.checked.cells.check(self.expansion, runs[0] as usize) else {
                if chunk.checked.cells.is_full() {
                    break;
                }
                continue;
            };
            chunk.add(cell, runs);
        }
        chunk.checked
    }
}

/// Runs under check.
struct Chunk<'a> {
    check: &'a RunCheck<'a>,
    checked: CheckedRuns,
    /// Usable robots by path and inertia policy.
    robots: HashMap<(PathBuf, Option<InertiaSpec>), Arc<Robot>>,
    /// Files found so far.
    paths: HashSet<PathBuf>,
    /// Findings so far, to count the errors.
    errors: Findings,
    files: LastFiles,
    /// Shapes of references by their keys.
    references: HashMap<u64, Shape>,
}

/// The outcome of a check whose error has been reported.
type Checked<T> = Option<T>;

impl Chunk<'_> {
    /// Adds runs that differ in their seeds alone; `cell` is the first of them.
    fn add(&mut self, cell: CheckedCell, numbers: &[u32]) {
        let run = &cell.run;
        self.checked.remote |= run.scenario.robot.backend.is_some();
        let first_seed = run.scenario.seed - (run.index % self.check.expansion.repetitions()) as u64;
        self.checked.seeds = match self.checked.seeds {
            None => Some((first_seed, false)),
            Some((seed, differ)) => Some((seed, differ || seed != first_seed)),
        };
        if self.errors.errors() >= MAX_ERRORS {
            return;
        }
        // Scripts see the seed.
        if numbers.len() > 1 && has_scripts(run) {
            for number in numbers {
                let mut cells = CheckedCells::default();
                let Some(cell) = cells.check(self.check.expansion, *number as usize) else { continue };
                self.add_alike(cell, std::slice::from_ref(number));
            }
            return;
        }
        self.add_alike(cell, numbers);
    }

    /// Adds runs of which the first is judged for all.
    fn add_alike(&mut self, cell: CheckedCell, numbers: &[u32]) -> Checked<()> {
        let CheckedCell { mut run, reference_has_own_seed } = cell;
        let repeat = self.check.expansion.repetitions();
        self.add_files(&run);
        let robots = self.robots(&run)?;
        let shape = self.build(&run, &robots)?;
        let reference = run.reference.take();
        let mut keys = self.keys(&run, &robots, numbers.len() + 1)?;
        let mut reference = match reference {
            Some(reference) => Some((self.reference_keys(&run, &reference, &shape, numbers.len())?, reference)),
            None => None,
        };
        let repetition = |number: usize| (number % repeat) as u64;
        let first_seed = run.scenario.seed - repetition(run.index);
        let timing = run.scenario.compare.as_ref().and_then(|c| c.timing_repeats).unwrap_or(0);
        let first = self.written(&run, keys.key(first_seed))?;
        self.checked.combinations.push((first, run.index - run.index % repeat));
        for number in numbers.iter().map(|number| *number as usize) {
            let by = repetition(number);
            let key = if by == 0 { first } else { self.written(&run, keys.key(first_seed + by))? };
            let reference = match &mut reference {
                Some((keys, reference)) => {
                    let later = if reference_has_own_seed { 0 } else { by - repetition(run.index) };
                    let key = keys.key(reference.scenario.seed + later);
                    Some(self.written(&run, key)?)
                }
                None => None,
            };
            self.checked.runs.push(CheckedRun { number, key, reference, timing });
        }
        Some(())
    }

    /// Keys of the references of a run and its repetitions; the first is judged for all.
    fn reference_keys(&mut self, of: &Run, run: &Run, shape: &Shape, repetitions: usize) -> Checked<RunKeys> {
        let robots = self.robots(run)?;
        let mut keys = self.keys(run, &robots, repetitions)?;
        let key = self.written(run, keys.key(run.scenario.seed))?;
        let other = match self.references.get(&key) {
            Some(known) => known.clone(),
            None => {
                let built = self.build(run, &robots)?;
                self.references.insert(key, built.clone());
                built
            }
        };
        if other != *shape {
            let ([joints, soles], [own_joints, own_soles]) = (other.0, shape.0);
            let message = if other.0 == shape.0 {
                let objects = |joints: &[usize]| format!("{} objects with {joints:?} joints", joints.len());
                let (its, own) = (objects(&other.1), objects(&shape.1));
                format!("the reference has {its}, the run {own}: they cannot be compared")
            } else {
                format!(
                    "the reference's robot has {joints} joints and {soles} soles, the run's {own_joints} and \
                     {own_soles}: they cannot be compared"
                )
            };
            let error = of.error_at("compare.reference", message, None);
            self.report(Finding::Scenario(Box::new(error)));
            return None;
        }
        Some(keys)
    }

    fn report(&mut self, finding: Finding) {
        if finding.severity() == Severity::Error {
            self.errors.push(finding.clone());
        }
        self.checked.found.push(RunFinding::Finding(finding));
    }

    /// Builds a run's setup to check it.
    fn build(&mut self, run: &Run, (robot, objects): &Robots) -> Checked<Shape> {
        match time_limited(self.check.time_limit, || setup_with(run, robot, objects)) {
            Ok(setup) => {
                if let Some(warning) = log_size::warning(run, &setup) {
                    self.report(Finding::Scenario(Box::new(warning)));
                }
                let objects = setup.objects.iter().map(|object| object.model.nj()).collect();
                Some(([setup.model.nj(), setup.model.soles.len()], objects))
            }
            Err(errors) => {
                errors.0.into_iter().for_each(|error| self.report(Finding::Scenario(Box::new(error))));
                None
            }
        }
    }

    fn keys(&mut self, run: &Run, (robot, objects): &Robots, repetitions: usize) -> Checked<RunKeys> {
        let keys = RunKeys::new(run, (robot, objects), repetitions, &mut self.files);
        self.written(run, keys)
    }

    fn written<T>(&mut self, run: &Run, result: Result<T, serde_json::Error>) -> Checked<T> {
        let message = |error| format!("{}: the scenario cannot be written out: {error}", run.file.display());
        result.map_err(|error| self.report(Finding::Plan(message(error)))).ok()
    }

    /// Adds the files that a run names, with warnings about symbolic links that redirect them.
    fn add_files(&mut self, run: &Run) {
        let robot = ("robot.model".to_owned(), run.resolve(&run.scenario.robot.model), None);
        let objects = run.object_models().map(|(i, path)| (format!("object.{i}.model"), path, None));
        let inputs = run.inputs.iter().map(|input| (input.key.clone(), input.path.clone(), Some(&*input.bytes)));
        for (key, path, bytes) in std::iter::once(robot).chain(objects).chain(inputs) {
            if !self.paths.insert(path.clone()) {
                continue;
            }
            if let Some(bytes) = bytes {
                let hash = blake3::hash(bytes).to_hex().to_string();
                self.checked.found.push(RunFinding::Used(written_name(run, &path), hash));
            }
            if let Some(warning) = link_warning(run, &key, &path) {
                self.checked.found.push(RunFinding::OfFile(FileIdentity::Path(path), vec![warning]));
            }
        }
    }

    /// The robot of a run and the models of its objects.
    fn robots(&mut self, run: &Run) -> Checked<Robots> {
        let spec = &run.scenario.robot;
        let robot = self.robot(run, "robot.model", (run.resolve(&spec.model), spec.inertia))?;
        let models = run.object_models();
        let models = models.map(|(i, path)| self.robot(run, &format!("object.{i}.model"), (path, None)));
        Some((robot, models.collect::<Option<_>>()?))
    }

    /// The robot at a path under an inertia policy, named at `key`.
    fn robot(&mut self, run: &Run, key: &str, identity: (PathBuf, Option<InertiaSpec>)) -> Checked<Arc<Robot>> {
        if let Some(robot) = self.robots.get(&identity) {
            return Some(robot.clone());
        }
        let mut robots = self.check.robots.lock().unwrap_or_else(PoisonError::into_inner);
        let robot = robots.get(&identity.0, identity.1);
        drop(robots);
        let of_file = FileIdentity::Robot(identity.0.clone(), identity.1);
        match robot {
            Ok(robot) => {
                // Objects touch with their shapes, not with soles.
                let is_object = key.starts_with("object.");
                let notices = robot.notices.iter().filter(|n| !(is_object && n.message.starts_with("no soles")));
                let notices = notices.map(|notice| Finding::Notice(notice.clone())).collect();
                self.checked.found.push(RunFinding::OfFile(of_file, notices));
                self.checked.found.push(RunFinding::Used(written_name(run, &identity.0), hash_of(&robot)));
                self.robots.insert(identity, robot.clone());
                Some(robot)
            }
            // The scenario names an unreadable file, so the error points into the scenario.
            Err(error @ RobotError::Read { .. }) => {
                let error = run.error_at(key, error.to_string(), None);
                self.report(Finding::Scenario(Box::new(error)));
                None
            }
            Err(error) => {
                let named_at = run.error_at(key, "", None).location();
                let finding = Finding::Robot { error: Box::new(error), named_at };
                self.checked.found.push(RunFinding::OfFile(of_file, vec![finding]));
                None
            }
        }
    }
}

/// True if the setup of a run may depend on its seed.
fn has_scripts(run: &Run) -> bool {
    let scenario = |run: &Run| {
        run.scenario.task.iter().any(|task| matches!(task, TaskSpec::Script(_)))
            || run.scenario.force.iter().any(|force| matches!(force, ForceSpec::Script(_)))
    };
    scenario(run) || run.reference.as_deref().is_some_and(scenario)
}

/// A warning about a symbolic link that redirects a file that a run names.
fn link_warning(run: &Run, key: &str, path: &Path) -> Option<Finding> {
    let home = run.file.parent().unwrap_or(Path::new(""));
    let real = input::outside_target(home, path)?;
    let message = format!("a symbolic link leads elsewhere: {} is {}", path.display(), real.display());
    let mut warning = run.error_at(key, message, None);
    warning.severity = Severity::Warning;
    Some(Finding::Scenario(Box::new(warning)))
}

/// A file as a scenario names it, whose path may differ between machines.
fn written_name(run: &Run, path: &Path) -> String {
    let home = run.file.parent().unwrap_or(Path::new(""));
    let below = path.strip_prefix(home).unwrap_or(path);
    format!("{}: {}", run.name, below.display())
}

/// A hash of all files of a robot.
fn hash_of(robot: &Robot) -> String {
    let mut hasher = blake3::Hasher::new();
    for (_, bytes) in &robot.files {
        hasher.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
    }
    hasher.finalize().to_hex().to_string()
}
