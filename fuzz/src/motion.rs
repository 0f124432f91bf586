//! Motion files of every kind; the first byte selects the kind.

use std::path::PathBuf;

use stiction::assemble;
use stiction::scenario::Run;
use stiction::sim::Simulation;

use super::{scenario, tree};

/// Kinds by letter: the task that plays the file, and the file's extension.
pub const KINDS: [(u8, &str, &str); 6] = [
    (b'p', PLAYBACK, "toml"),
    (b'c', PLAYBACK, "csv"),
    (b'l', LOOP, "csv"),
    (b'r', PLAYBACK, "mcap"),
    (b'b', MOCAP, "bvh"),
    (b'm', MOCAP, "csv"),
];

const PLAYBACK: &str = r#"
robot.model = "../robots/hoap2/hoap2.toml"
task = [{ type = "playback", file = "motions/bow.toml", ends = "natural" }]
"#;
const LOOP: &str = r#"
robot.model = "../robots/hoap2/hoap2.toml"
task = [{ type = "playback", file = "motions/bow.toml", loop = true, speed = 2.0 }]
"#;
const MOCAP: &str = r#"
robot.model = "../robots/hoap2/hoap2.toml"
control.rate = 100.0
[[task]]
type = "mocap"
file = "motions/wave.bvh"
start = 0.25
map."Neck.Yrotation" = { joint = "head_pan", scale = -1.0 }
map."LeftForeArm.Xrotation" = { joint = "left_elbow", scale = -1.0, offset = "90 deg" }
"#;

thread_local! {
    static RUNS: Vec<(u8, Run)> = KINDS.iter().map(|(kind, text, extension)| {
        let mut run = tree::run(text);
        run.inputs[0].path = PathBuf::from(format!("fuzzed.{extension}"));
        (*kind, run)
    }).collect();
}

/// Reads a motion file; the first byte is the letter of its kind.
pub fn take(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    let run = RUNS.with(|runs| runs.iter().find(|(k, _)| k == kind).map(|(_, run)| run.clone()));
    let Some(mut run) = run else { return };
    run.inputs[0].bytes = bytes.into();
    let Some(robot) = tree::robot(&run) else { panic!("HOAP-2 is not there") };
    match assemble::setup(&run, &robot) {
        Ok(setup) => {
            let _ = Simulation::new(setup);
        }
        Err(wrong) => scenario::show(&wrong),
    }
}
