//! Runs tasks of type `policy` on HOAP-2, in simulations and in given states.

use stiction::assemble;
use stiction::dynamics::State;
use stiction::sim::Setup;
use stiction::task::server::TickInput;
use stiction::task::{Command, SensorReadings};

use crate::support::folder::{Folder, robot_of};

/// A scenario of HOAP-2 with the task whose keys after `file` are given.
pub fn hoap2(task: &str) -> String {
    format!(
        "duration = 1.0\nrobot = {{ model = \"ROBOTS/hoap2/hoap2.toml\" }}\n\
         [[task]]\ntype = \"policy\"\nfile = \"n.onnx\"\n{task}\n"
    )
}

pub fn setup(folder: &Folder, text: &str) -> Setup {
    let run = folder.run(text).unwrap_or_else(|e| panic!("{e}"));
    assemble::setup(&run, &robot_of(&run)).unwrap_or_else(|e| panic!("{e}"))
}

/// Commands of the ticks of a robot whose state `change` sets before each tick.
pub fn ticks(setup: &mut Setup, count: usize, mut change: impl FnMut(&mut State, &mut SensorReadings)) -> Vec<Command> {
    let mut state = State::home(&setup.model);
    let mut sensed = SensorReadings::blank(&setup.model);
    (0..count)
        .map(|_| {
            state.time = setup.tasks.next_tick().expect("the task runs");
            change(&mut state, &mut sensed);
            let now = TickInput {
                model: &setup.model,
                gravity: setup.gravity,
                floor: setup.floor.plane(),
                state: &state,
                sensed: &sensed,
            };
            setup.tasks.run(&now, |_, _| {}).unwrap_or_else(|e| panic!("{e}"));
            setup.tasks.command.clone()
        })
        .collect()
}
