//! Runs scenario text against the robots of the tree.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use stiction::robot;
use stiction::scenario;
use stiction::sim::{Blind, Metrics, Outcome, Simulation, build};

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// Prepares the only run of a scenario given as text; paths in it start at the repository's root.
pub fn simulation(text: &str) -> Simulation {
    let file = scenario::parse(&root().join("test.toml"), text).unwrap_or_else(|e| panic!("{e}"));
    let runs = file.expand(&[]).unwrap_or_else(|e| panic!("{e}"));
    let robot = robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"));
    let setup = build::setup(&runs[0], &robot).unwrap_or_else(|e| panic!("{e}"));
    Simulation::new(setup).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs it to the end; it must get there.
pub fn run(text: &str) -> Metrics {
    let mut sim = simulation(text);
    let (outcome, message) = sim.run(&mut Blind, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}\n{:?}", sim.metrics());
    sim.metrics().clone()
}
