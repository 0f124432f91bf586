//! Scripts of tasks and forces: loaded, and called as in a run's first steps. The first byte
//! selects the use.

use stiction::assemble;
use stiction::scenario::Run;
use stiction::sim::{NullObserver, Simulation};

use super::{scenario, tree};

/// Uses by letter: a scenario whose only script is the fuzzed one. Those in capitals also change
/// parameters, for which a script needs a function `change`.
pub const USES: [(u8, &str); 5] = [
    (
        b't',
        "robot.model = \"extending/nodder/nodder.toml\"\n[[task]]\ntype = \"script\"\nfile = \"tasks/wave.luau\"\n\
        params = { angle = 0.8, time = 1.0, list = [1, \"two\", { three = 3.0 }] }\n",
    ),
    (
        b'T',
        "robot.model = \"extending/nodder/nodder.toml\"\n[[task]]\ntype = \"script\"\nfile = \"tasks/wave.luau\"\n\
        params = { angle = 0.8, time = 1.0 }\nchange = [{ at = 0.0015, params = { angle = 0.5 } }]\n",
    ),
    (
        b'H',
        "robot.model = \"../robots/hoap2/hoap2.toml\"\n[[task]]\ntype = \"script\"\nfile = \"tasks/wave.luau\"\n\
        params = { amplitude = 0.3, frequency = 1.0, duration = 3.5 }\nchange = [{ at = 0.0015, params = { amplitude = 0.5 } }]\n",
    ),
    (
        b'f',
        "robot.model = \"../robots/block/block.toml\"\n[[force]]\ntype = \"script\"\nfile = \"forces/attractor.luau\"\n\
        params = { strength = 10.0, c = 0.3 }\n",
    ),
    (
        b'F',
        "robot.model = \"../robots/block/block.toml\"\n[[force]]\ntype = \"script\"\nfile = \"forces/attractor.luau\"\n\
        params = { strength = 10.0 }\nchange = [{ at = 0.0015, params = { strength = 5.0 } }]\n",
    ),
];
/// Steps after the first calls.
const STEPS: usize = 5;

thread_local! {
    static RUNS: Vec<(u8, Run)> = USES.iter().map(|(kind, text)| (*kind, tree::run(text))).collect();
}

/// Runs a script; the first byte is the letter of its use.
pub fn take(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    let run = RUNS.with(|runs| runs.iter().find(|(k, _)| k == kind).map(|(_, run)| run.clone()));
    let Some(mut run) = run else { return };
    run.inputs[0].bytes = bytes.into();
    let Some(robot) = tree::robot(&run) else { panic!("a robot of the repository is not there") };
    let setup = match assemble::setup(&run, &robot) {
        Ok(setup) => setup,
        Err(wrong) => return scenario::show(&wrong),
    };
    let Ok(mut simulation) = Simulation::new(setup) else { return };
    if simulation.begin(&mut NullObserver).is_ok() {
        for _ in 0..STEPS {
            if simulation.step(&mut NullObserver).is_err() {
                break;
            }
        }
    }
}
