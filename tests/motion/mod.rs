//! Joint motions: tasks `sine`, `playback`, `mocap` against closed forms, and the files they read.

mod broken;
mod inputs;
mod mocap;
mod playback;
mod ranges;
mod recorded;
mod sine;

use crate::analytic::support::{Recording, finish};
use crate::identities::allocations::count;
use std::fs;
use std::path::Path;
use stiction::assemble;
use stiction::dynamics::State;
use stiction::robot;
use stiction::scenario::{self, Diagnostics, Run};
use stiction::sim::{Metrics, Simulation};
use stiction::task::server::TickInput;
use stiction::task::{Command, SensorReadings};

/// A temporary folder with the files of a scenario.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// With these files in it.
    pub fn with(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        folder
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// The only run of a scenario in the folder, given as text; `ROBOTS` stands for the
    /// repository's folder of robots.
    pub fn run(&self, text: &str) -> Result<Run, Diagnostics> {
        let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
        let text = text.replace("ROBOTS", robots.to_str().unwrap());
        Ok(scenario::parse(&self.path().join("s.toml"), text)?.expand(&[])?.remove(0))
    }

    /// The error of a scenario, from any stage of loading.
    pub fn refused(&self, text: &str) -> Diagnostics {
        let run = match self.run(text) {
            Ok(run) => run,
            Err(found) => return found,
        };
        assemble::setup(&run, &robot_of(&run)).err().unwrap_or_else(|| panic!("not refused: {text}"))
    }

    /// Runs a scenario to its end.
    pub fn watch(&self, text: &str) -> (Metrics, Recording, Vec<String>) {
        let run = self.run(text).unwrap_or_else(|e| panic!("{e}"));
        let setup = assemble::setup(&run, &robot_of(&run)).unwrap_or_else(|e| panic!("{e}"));
        let notes = setup.notes.clone();
        let mut recorded = Recording::default();
        let metrics = finish(&mut Simulation::new(setup).unwrap_or_else(|e| panic!("{e}")), &mut recorded);
        (metrics, recorded, notes)
    }
}

/// The robot of a run.
pub fn robot_of(run: &Run) -> robot::Robot {
    robot::load(&run.resolve(&run.scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"))
}

/// A double pendulum whose joints have no limits.
pub const PENDULUM: &str = "duration = 4.0
robot = { model = \"ROBOTS/pendulum/pendulum.urdf\", posture = { shoulder = 0.3, elbow = -0.2 } }
";

/// Joint commands of a tick.
#[derive(Clone, Debug)]
pub struct TickCommand {
    pub time: f64,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
}

/// Calls the task server of a scenario at each of its ticks, without simulating anything.
pub fn commands(folder: &Folder, text: &str) -> Vec<TickCommand> {
    let run = folder.run(text).unwrap_or_else(|e| panic!("{e}"));
    let mut setup = assemble::setup(&run, &robot_of(&run)).unwrap_or_else(|e| panic!("{e}"));
    let (mut state, sensed) = (State::home(&setup.model), SensorReadings::blank(&setup.model));
    let ticks = (run.scenario.duration * run.scenario.control.rate).round() as usize;
    let tick = |k: usize| {
        state.time = k as f64 / run.scenario.control.rate;
        let now = TickInput {
            model: &setup.model,
            gravity: setup.gravity,
            floor: setup.floor.plane(),
            state: &state,
            sensed: &sensed,
        };
        setup.tasks.run(&now, |_, _| ()).unwrap();
        let Command { position, velocity, .. } = setup.tasks.command.clone();
        TickCommand { time: state.time, position, velocity }
    };
    (0..=ticks).map(tick).collect()
}

/// The greatest distance of the commanded velocities of a joint from central differences of its
/// positions, away from the times given, and the greatest step of its velocity between two ticks.
pub fn unsteadiness(commands: &[TickCommand], joint: usize, but: &[f64]) -> (f64, f64) {
    let far = |a: &TickCommand| but.iter().all(|t| (a.time - t).abs() > 0.0015);
    let slope = |w: &[TickCommand]| (w[2].position[joint] - w[0].position[joint]) / (w[2].time - w[0].time);
    let apart = commands.windows(3).filter(|w| far(&w[1])).map(|w| (slope(w) - w[1].velocity[joint]).abs());
    let steps = commands.windows(2).map(|w| (w[1].velocity[joint] - w[0].velocity[joint]).abs());
    (apart.fold(0.0, f64::max), steps.fold(0.0, f64::max))
}

#[test]
fn nothing_is_allocated_at_a_tick() {
    let files = [("m.csv", "time,shoulder\n0,0.3\n0.01,0.5\n0.02,0.3\n"), ("c.csv", "time,a\n0,0\n0.03,1\n")];
    let folder = Folder::with(&files);
    let text = format!(
        "{PENDULUM}
        [[task]]
        type = \"playback\"
        file = \"m.csv\"
        loop = true
        blend = 0.01
        change = [{{ at = 0.01, speed = 2 }}]
        [[task]]
        type = \"mocap\"
        file = \"c.csv\"
        blend = 0.01
        map = {{ a = {{ joint = \"elbow\" }} }}
        [[task]]
        type = \"sine\"
        ramp = 0.01
        joints = {{ shoulder = {{ amplitude = 0.1 }} }}
        change = [{{ at = 0.01, joints = {{ shoulder = {{ frequency = 2 }} }} }}]\n"
    );
    let run = folder.run(&text).unwrap_or_else(|e| panic!("{e}"));
    let mut setup = assemble::setup(&run, &robot_of(&run)).unwrap_or_else(|e| panic!("{e}"));
    let (mut state, sensed) = (State::home(&setup.model), SensorReadings::blank(&setup.model));
    let mut tick = |k: usize| {
        state.time = k as f64 / run.scenario.control.rate;
        let now = TickInput {
            model: &setup.model,
            gravity: setup.gravity,
            floor: setup.floor.plane(),
            state: &state,
            sensed: &sensed,
        };
        setup.tasks.run(&now, |_, _| ()).unwrap();
    };
    assert_eq!(count(|| (0..50).for_each(&mut tick)), 0);
}
