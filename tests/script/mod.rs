//! Scripts: their inputs, their effects, and their limits.

mod abuse;
mod bounds;
mod elementary_functions;
mod files;
mod forces;
mod points;
mod tasks;

use std::fs;
use std::sync::atomic::AtomicBool;
use stiction::assemble;
use stiction::scenario::Diagnostics;
use stiction::sim::{NullObserver, Observer, Outcome, Simulation};
use stiction::{robot, scenario};
use tempfile::TempDir;

/// A folder with a scenario `s.toml` and its script `s.luau`.
struct ScriptedRun(TempDir);

impl ScriptedRun {
    fn new(scenario: &str, script: &str) -> Self {
        let folder = TempDir::new().expect("a folder");
        fs::write(folder.path().join("s.toml"), scenario).expect("it is writable");
        fs::write(folder.path().join("s.luau"), script).expect("it is writable");
        ScriptedRun(folder)
    }

    /// The first run, built.
    fn build(&self) -> Result<Simulation, Diagnostics> {
        let runs = scenario::load(&self.0.path().join("s.toml"))?.expand(&[])?;
        let robot = robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).expect("the robot is sound");
        Ok(Simulation::new(assemble::setup(&runs[0], &robot)?).expect("it can be simulated"))
    }

    fn simulation(&self) -> Simulation {
        self.build().unwrap_or_else(|e| panic!("{e}"))
    }

    /// Outcome of the run.
    fn end(&self, observer: &mut dyn Observer) -> (Outcome, String) {
        self.simulation().run(observer, &AtomicBool::new(false))
    }
}

/// Path of a robot of the repository.
fn robot(path: &str) -> String {
    format!("{}/robots/{path}", env!("CARGO_MANIFEST_DIR"))
}

/// The double pendulum of the repository, hanging from its fixed base, driven as `drive` says.
fn pendulum(duration: f64, drive: &str, rest: &str) -> String {
    format!(
        "duration = {duration:?}
        robot = {{ model = {:?}, soles = [], joint_default = {{ {drive} }}, posture = {{ shoulder = 0.4, elbow = 0.3 }} }}
        integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
        {rest}\n",
        robot("pendulum/pendulum.urdf")
    )
}

const TASK: &str = "[[task]]\ntype = \"script\"\nfile = \"s.luau\"\n";
const FORCE: &str = "[[force]]\ntype = \"script\"\nfile = \"s.luau\"\n";

/// Runs to the end and asserts that the run passes.
fn passes(scenario: &str, script: &str) -> Simulation {
    let mut sim = ScriptedRun::new(scenario, script).simulation();
    let (outcome, message) = sim.run(&mut NullObserver, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}");
    sim
}
