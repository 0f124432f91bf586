//! Entry points of the library: from a scenario file to runs, simulations and batches.
//!
//! The crate root exports its types. The program does not use it.
//!
//! Imports: `robot`, `sim`, `scenario`, `assemble`, `batch`, `report`. Used by: the crate root.

use crate::assemble;
use crate::batch::{Batch, BatchError, Findings, Options, Progress, Report, on_threads, prepare, simulate};
use crate::report::batch_page;
use crate::robot::{self, InertiaPolicy, Robot, RobotError};
use crate::scenario::{self, Diagnostics, InertiaSpec, Run as ScenarioRun, ScenarioFile};
use crate::sim::{RunError, Setup, Simulation};
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};

/// Errors of the library; each displays file, line, what was found and what is expected.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scenario is not valid, or does not fit its robot.
    #[error(transparent)]
    Scenario(#[from] Diagnostics),
    /// The robot cannot be loaded.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The run cannot start, or has ended early.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Scenarios of a batch are not valid.
    #[error("{}", .0.iter().map(|finding| finding.render(false)).collect::<Vec<_>>().join("\n"))]
    Plan(Findings),
    /// The batch as a whole failed.
    #[error(transparent)]
    Batch(#[from] BatchError),
}

/// A scenario file with overrides: one run, or a sweep of many.
///
/// ```
/// # fn main() -> Result<(), stiction::Error> {
/// let text = r#"
///     duration = 0.5
///     robot = { model = "robots/block/block.toml", base = { linear_velocity = [1, 0, 0] } }
///     sweep = { grid = { "floor.friction" = [0.3, 0.6] } }
/// "#;
/// // Paths in the text start at the folder of the first argument, which need not exist.
/// for run in stiction::Scenario::parse("slide.toml", text)?.runs()? {
///     let mut simulation = run.simulation()?;
///     simulation.run_to_end(&mut ())?;
///     let friction = run.scenario.floor.friction.static_;
///     let distance = 1.0 / (2.0 * friction * 9.81);
///     assert!((simulation.metrics().final_base_position[0] - distance).abs() < 1e-12);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Scenario {
    file: ScenarioFile,
    overrides: Vec<(String, toml::Value)>,
}

impl Scenario {
    /// Loads a scenario file.
    ///
    /// # Errors
    /// The file cannot be read or is not TOML; [`runs`](Self::runs) checks its keys and values.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Ok(Self { file: scenario::load(path.as_ref())?, overrides: Vec::new() })
    }

    /// Reads a scenario from text. `path` names it in messages, and relative paths in the text
    /// start at its folder.
    ///
    /// # Errors
    /// The text is not TOML; [`runs`](Self::runs) checks its keys and values.
    pub fn parse(path: impl AsRef<Path>, text: impl Into<String>) -> Result<Self, Error> {
        Ok(Self { file: scenario::parse(path.as_ref(), text)?, overrides: Vec::new() })
    }

    /// Replaces the value under a dotted key, such as `contact.method`, in every run.
    pub fn set(mut self, key: impl Into<String>, value: impl Into<toml::Value>) -> Self {
        self.overrides.push((key.into(), value.into()));
        self
    }

    /// Name of the scenario, which is that of its file.
    pub fn name(&self) -> String {
        self.file.name()
    }

    /// All runs of the sweep, or the only one.
    ///
    /// # Errors
    /// A key, a value or a combination of values is not valid.
    pub fn runs(&self) -> Result<Vec<Run>, Error> {
        Ok(self.file.expand(&self.overrides)?.into_iter().map(Run).collect())
    }
}

/// A run of a scenario: the scenario with one combination of the values of its sweep.
///
/// The fields are those of [`ScenarioRun`]. Values changed here are not checked before
/// [`setup`](Self::setup).
#[derive(Clone, Debug)]
pub struct Run(ScenarioRun);

impl From<ScenarioRun> for Run {
    fn from(run: ScenarioRun) -> Self {
        Self(run)
    }
}

impl Deref for Run {
    type Target = ScenarioRun;

    fn deref(&self) -> &ScenarioRun {
        &self.0
    }
}

impl DerefMut for Run {
    fn deref_mut(&mut self) -> &mut ScenarioRun {
        &mut self.0
    }
}

impl Run {
    /// Loads the run's robot.
    ///
    /// # Errors
    /// A file of the robot cannot be read or does not describe a robot.
    pub fn load_robot(&self) -> Result<Robot, Error> {
        let spec = &self.scenario.robot;
        let policy = spec.inertia.map(|policy| match policy {
            InertiaSpec::Refuse => InertiaPolicy::Refuse,
            InertiaSpec::Repair => InertiaPolicy::Repair,
        });
        Ok(robot::load_with(&self.resolve(&spec.model), policy)?)
    }

    /// The setup of the simulation, in physical terms. Its fields may be changed before it is
    /// passed to [`Simulation::new`], for example to add a force model or a task.
    ///
    /// # Errors
    /// The robot cannot be loaded, or a name or value of the scenario does not fit it.
    pub fn setup(&self) -> Result<Setup, Error> {
        Ok(assemble::setup(self, &self.load_robot()?)?)
    }

    /// A simulation of this run, before its first step.
    ///
    /// # Errors
    /// See [`Run::setup`].
    pub fn simulation(&self) -> Result<Simulation, Error> {
        Ok(Simulation::new(self.setup()?)?)
    }
}

/// Executes all runs of scenario files in parallel and writes results to the folder
/// `options.output`, as `runner run` does.
///
/// # Errors
/// A scenario or robot is not valid, in which case nothing runs, or results cannot be written. A
/// run that fails is not an error but an outcome in the report.
pub fn run_batch<P: AsRef<Path>>(scenarios: impl IntoIterator<Item = P>, options: Options) -> Result<Report, Error> {
    let files: Vec<PathBuf> = scenarios.into_iter().map(|path| path.as_ref().to_owned()).collect();
    let prepared = on_threads(options.jobs, || prepare(&files, &[], scenario::DEFAULT_MAX_RUNS))?;
    let (plan, _) = prepared.map_err(Error::Plan)?;
    Ok(Batch::new(plan, options, batch_page)?.run(Progress::Silent, &simulate)?)
}
