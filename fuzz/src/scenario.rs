//! Scenario files: parsed, expanded, each run checked and assembled with its robot.

use stiction::assemble;
use stiction::robot::Robot;
use stiction::scenario::{self, Diagnostics, Run};
use stiction::sim::Simulation;

use super::tree;

/// Greatest number of runs that a file may expand to.
const MOST_RUNS: usize = 256;
/// Greatest number of runs of a file that are assembled with their robot.
const MOST_SETUPS: usize = 3;

/// Reads the text of a scenario file.
pub fn take(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let file = match scenario::parse(&tree::root().join("scenarios/fuzzed.toml"), text) {
        Ok(file) => file,
        Err(wrong) => return show(&wrong),
    };
    let _ = file.table();
    let expansion = match file.expansion(&[], MOST_RUNS) {
        Ok(expansion) => expansion,
        Err(wrong) => return show(&wrong),
    };
    let mut runs = Vec::new();
    let mut collect = |run: Run| {
        show(&run.warnings);
        if runs.len() < MOST_SETUPS {
            runs.push(run);
        }
    };
    match expansion.check(&mut collect) {
        Ok(idle) => show(&idle),
        Err(wrong) => return show(&wrong),
    }
    for run in &runs {
        assert_round_trip(run);
        if let Some(robot) = tree::robot(run) {
            assemble_run(run, &robot);
            // Self-collision takes longer to prepare than everything else.
            if run.scenario.self_collision.is_some() {
                break;
            }
        }
    }
}

/// Asserts that the resolved text of the run gives the same scenario.
fn assert_round_trip(run: &Run) {
    let file = scenario::parse(&run.file, run.resolved_toml.as_str()).expect("a resolved scenario is sound");
    let mut scenarios = Vec::new();
    let expansion = file.expansion(&[], 1).expect("a resolved scenario is one run");
    expansion.check(&mut |run| scenarios.push(run.scenario)).expect("nothing is wrong with a resolved scenario");
    assert!(scenarios == [run.scenario.clone()], "a resolved scenario reads back to another one");
}

fn assemble_run(run: &Run, robot: &Robot) {
    match assemble::setup(run, robot) {
        Ok(setup) => {
            let _ = Simulation::new(setup);
        }
        Err(wrong) => show(&wrong),
    }
}

/// Renders the messages for a user.
pub fn show(wrong: &Diagnostics) {
    let _ = (wrong.render(false), wrong.render(true));
}
