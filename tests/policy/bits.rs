//! Equal runs of a policy give equal bits: on more threads, resumed, replayed, and after a return to a checkpoint.

use std::path::Path;

use stiction::sim::Simulation;

use super::folder;
use super::onnx_file::{FLOAT, constant, file, node, value};
use super::support::{hoap2, setup};
use crate::support::place::Place;
use crate::support::same::assert_same;

/// A recurrent network with history and previous actions: h' = tanh(h + x W), y = h' V.
fn recurrent() -> Vec<u8> {
    let weight = |i: usize| ((i as f32 * 0.618).fract() - 0.5) * 0.2;
    let weights = |count: usize| (0..count).map(weight).collect::<Vec<_>>();
    // Two observations of 3 + 4 + 4 numbers.
    file(
        &[value("obs", FLOAT, &[None, Some(22)]), value("h_in", FLOAT, &[Some(1), Some(5)])],
        &[value("actions", FLOAT, &[None, Some(4)]), value("h_out", FLOAT, &[Some(1), Some(5)])],
        &[constant("W", &[22, 5], &weights(110)), constant("V", &[5, 4], &weights(20))],
        &[
            node("MatMul", &["obs", "W"], &["x"]),
            node("Add", &["h_in", "x"], &["s"]),
            node("Tanh", &["s"], &["h_out"]),
            node("MatMul", &["h_out", "V"], &["actions"]),
        ],
    )
}

const TASK: &str = "decimation = 5
history = 2
state = [{ input = \"h_in\", output = \"h_out\" }]
observations = [{ term = \"gravity\" }, { term = \"joint-velocities\" }, { term = \"previous-action\" }]
action = { joints = [\"waist_pitch\", \"*_elbow\", \"head_pan\"], scale = 0.3 }
[[force]]
type = \"push\"
link = \"torso\"
force = [10, 4, 0]
start = 0.05
duration = 0.1";

/// As before a return, and in another simulation of the same run. The times are between evaluations.
#[test]
fn a_return_to_a_checkpoint_repeats_the_bits() {
    let folder = folder(recurrent());
    let text = hoap2(TASK).replace("duration = 1.0", "duration = 0.3");
    let new = || Simulation::new(setup(&folder, &text)).unwrap_or_else(|e| panic!("{e}"));
    let to_end = |simulation: &mut Simulation| {
        simulation.run_to_end(&mut ()).unwrap_or_else(|e| panic!("{e:?}"));
        (simulation.state().clone(), simulation.metrics().clone())
    };
    let end = to_end(&mut new());
    for time in [0.0521, 0.1833] {
        let mut first = new();
        first.advance_to(time, &mut ()).expect("it runs");
        let checkpoint = first.checkpoint().unwrap_or_else(|e| panic!("{e:?}"));
        assert_eq!(to_end(&mut first), end, "{time}");
        first.return_to(&checkpoint).unwrap_or_else(|e| panic!("{e:?}"));
        assert_eq!(to_end(&mut first), end, "returned to {time}");
        let mut other = new();
        other.advance_to(0.25, &mut ()).expect("it runs");
        other.return_to(&checkpoint).unwrap_or_else(|e| panic!("{e:?}"));
        assert_eq!(to_end(&mut other), end, "another simulation at {time}");
    }
}

#[test]
fn threads_resumed_batches_and_replays_give_the_same_bits() {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    let text = hoap2(TASK).replace("ROBOTS", robots.to_str().expect("a path in UTF-8"));
    let text = format!("{text}\n[sweep.grid]\n\"force.0.force.0\" = [5, 10, 15, 20]\n");
    let place = Place::new();
    place.write("p.toml", text).write("n.onnx", recurrent());
    let run = |arguments: &[&str]| {
        place.runner(&[&["p.toml", "--set", "duration=0.25"], arguments].concat()).exits(0);
    };
    run(&["-j", "1", "--output", "one"]);
    run(&["-j", "2", "--output", "two"]);
    assert_same(&place.path("one"), &place.path("two"));
    // A batch that lacks two runs.
    let folders = std::fs::read_dir(place.path("two/p")).expect("runs").map(|entry| entry.expect("a run").path());
    for folder in folders.take(2) {
        std::fs::remove_dir_all(folder).expect("it can be removed");
    }
    run(&["-j", "2", "--output", "two", "--resume"]);
    // It has a second line for each run that was repeated.
    for folder in ["one", "two"] {
        std::fs::remove_file(place.path(folder).join("runs.jsonl")).expect("lines of the runs");
    }
    assert_same(&place.path("one"), &place.path("two"));
    let replayed = place.runner(&["replay", "one"]).exits(0);
    assert!(replayed.stdout.contains("4"), "{}", replayed.stdout);
    // The network belongs to the key, and its hash to the record.
    let record = std::fs::read_dir(place.path("one/p")).expect("runs").next().expect("a run").expect("a run").path();
    let record = std::fs::read_to_string(record.join("run.json")).expect("a record");
    assert!(record.contains("\"n.onnx\""), "{record}");
    let listed = |place: &Place| place.runner(&["list", "p.toml"]).exits(0).stdout;
    let before = listed(&place);
    place.write("n.onnx", [recurrent(), vec![0x28, 0x01]].concat());
    assert_ne!(listed(&place), before, "another file gives other keys");
}

#[test]
fn numbers_that_are_not_finite_end_the_run_with_their_time() {
    let one = [None, Some(1)];
    let network =
        file(&[value("obs", FLOAT, &one)], &[value("y", FLOAT, &one)], &[], &[node("Sqrt", &["obs"], &["y"])]);
    let task = "observations = [{ term = \"cosine\", period = 4 }]\nduration = 3
        action = { joints = [\"left_knee\"], scale = 1e-6 }\n[control]\nrate = 2";
    let folder = folder(network);
    let text = hoap2(task).replace("duration = 1.0", "duration = 3.0");
    let mut simulation = Simulation::new(setup(&folder, &text)).unwrap_or_else(|e| panic!("{e}"));
    let error = simulation.run_to_end(&mut ()).expect_err("the cosine is negative from 1 s on");
    assert_eq!(error.message, "task policy: the network's output for joint `left_knee` is NaN at 1.5 s");
}
