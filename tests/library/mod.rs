//! Tests of the library interface: the exports of the crate root, and the programs of `examples/`.

#[path = "../../examples/own_contact_method.rs"]
mod own_contact_method;
#[path = "../../examples/own_force_and_task.rs"]
mod own_force_and_task;
#[path = "../../examples/run_scenario.rs"]
mod run_scenario;
#[path = "../../examples/step_and_read.rs"]
mod step_and_read;

mod checkpoint;

use std::sync::Arc;
use stiction::batch::on_threads;
use stiction::{Error, Options, Outcome, Scenario, Setup, Simulation, run_batch};

#[test]
fn examples_run() {
    run_scenario::main().unwrap();
    step_and_read::main().unwrap();
    own_force_and_task::main().unwrap();
    own_contact_method::main().unwrap();
}

#[test]
fn advancing_in_parts_gives_the_bits_of_an_uninterrupted_run() {
    let run = Scenario::load("scenarios/hoap2-pushed.toml").unwrap().set("duration", 1.5).runs().unwrap().remove(0);
    let (mut whole, mut parts) = (run.simulation().unwrap(), run.simulation().unwrap());
    whole.run_to_end(&mut ()).unwrap();
    for k in 1..30 {
        parts.advance_to(0.05 * f64::from(k), &mut ()).unwrap();
        // Reading changes nothing.
        assert!(parts.snapshot().time >= 0.05 * f64::from(k));
    }
    parts.run_to_end(&mut ()).unwrap();
    assert_eq!(parts.state(), whole.state());
    assert_eq!(parts.metrics(), whole.metrics());
}

#[test]
fn a_setup_needs_only_a_robot() {
    let scenario = Scenario::parse("block.toml", "robot = { model = \"robots/block/block.toml\" }").unwrap();
    let robot = scenario.runs().unwrap()[0].load_robot().unwrap();
    let mut setup = Setup::new(Arc::new(robot.model));
    // The block slides flat on the floor and stops after v0^2 / (2 mu g), mu = 0.6.
    setup.start.position.z = 0.05;
    setup.start.v[0] = 1.0;
    let mut simulation = Simulation::new(setup).unwrap();
    simulation.run_to_end(&mut ()).unwrap();
    let distance = 1.0 / (2.0 * 0.6 * 9.81);
    // Friction is constant, so the integrator is exact; the stop is located to rounding.
    assert!((simulation.state().position.x - distance).abs() < 1e-12);
}

#[test]
fn errors_contain_file_line_and_key() {
    let error =
        Scenario::parse("typo.toml", "robot = { model = \"robots/block/block.toml\" }\nfloor = { fricton = 1 }");
    let error = error.unwrap().runs().unwrap_err();
    assert!(matches!(error, Error::Scenario(_)));
    let text = error.to_string();
    assert!(text.contains("typo.toml:2:") && text.contains("fricton") && text.contains("friction"), "{text}");
    let missing = Scenario::parse("missing.toml", "robot = { model = \"robots/none.urdf\" }").unwrap().runs().unwrap();
    assert!(matches!(missing[0].simulation().err(), Some(Error::Robot(_))));
}

#[test]
fn work_on_the_threads_of_a_batch_has_as_many_as_its_jobs() {
    let threads = |jobs| on_threads(jobs, || rayon::broadcast(|_| std::thread::current().id()).len()).unwrap();
    let processors = std::thread::available_parallelism().unwrap().get();
    assert_eq!([0, 1, 3].map(threads), [1, 1, processors.min(3)]);
}

#[test]
fn a_batch_writes_its_results() {
    let folder = tempfile::tempdir().unwrap();
    let options = Options { output: folder.path().join("results"), jobs: 2, timing: false, ..Options::default() };
    let report = run_batch(["scenarios/sliding-block.toml", "scenarios/drop.toml"], options).unwrap();
    assert_eq!(report.finished.len(), 2);
    assert!(report.finished.iter().all(|run| run.row.outcome == Outcome::Passed));
    assert!(folder.path().join("results/summary.csv").is_file());
    let options = Options { output: folder.path().join("other"), ..Options::default() };
    assert!(matches!(run_batch(["scenarios/none.toml"], options), Err(Error::Plan(_) | Error::Scenario(_))));
}
