//! Scenario files: read, expanded, each run judged and met with its robot.

use stiction::assemble;
use stiction::robot::Robot;
use stiction::scenario::{self, Diagnostics, Run};
use stiction::sim::Simulation;

use super::tree;

/// Runs a file may expand to.
const MOST_RUNS: usize = 256;
/// Runs of a file that meet their robot.
const MOST_SETUPS: usize = 3;

/// Takes the text of a scenario file.
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
    let mut keep = |run: Run| {
        show(&run.warnings);
        if runs.len() < MOST_SETUPS {
            runs.push(run);
        }
    };
    match expansion.check(&mut keep) {
        Ok(idle) => show(&idle),
        Err(wrong) => return show(&wrong),
    }
    for run in &runs {
        again(run);
        if let Some(robot) = tree::robot(run) {
            meet(run, &robot);
            // Bodies that must not meet take longer to prepare than all the rest.
            if run.scenario.self_collision.is_some() {
                break;
            }
        }
    }
}

/// The run with every value written out is the same scenario.
fn again(run: &Run) {
    let file = scenario::parse(&run.file, run.resolved_toml.as_str()).expect("a resolved scenario is sound");
    let mut scenarios = Vec::new();
    let expansion = file.expansion(&[], 1).expect("a resolved scenario is one run");
    expansion.check(&mut |run| scenarios.push(run.scenario)).expect("nothing is wrong with a resolved scenario");
    assert!(scenarios == [run.scenario.clone()], "a resolved scenario reads back to another one");
}

fn meet(run: &Run, robot: &Robot) {
    match assemble::setup(run, robot) {
        Ok(setup) => {
            let _ = Simulation::new(setup);
        }
        Err(wrong) => show(&wrong),
    }
}

/// What a user would be shown.
pub fn show(wrong: &Diagnostics) {
    let _ = (wrong.render(false), wrong.render(true));
}
