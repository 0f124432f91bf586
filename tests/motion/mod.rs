//! Joint motions: tasks `sine`, `playback`, `mocap` against closed forms, and the files they read.

mod broken;
mod inputs;
mod mocap;
mod playback;
mod ranges;
mod recorded;
mod sine;

pub use crate::support::folder::{Folder, robot_of};

use crate::support::counting::count;
use stiction::assemble;
use stiction::dynamics::State;
use stiction::task::server::TickInput;
use stiction::task::{Command, SensorReadings};

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
