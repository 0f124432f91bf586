//! Scripts as files of a batch: checked before any run starts, part of the run key, stored in the
//! log, and independent of the number of threads.

use crate::cli::Place;
use std::fs;

const WAVE: &str = "duration = 0.1
robot = { model = \"HOAP2\" }
[[task]]
type = \"script\"
file = \"tasks/wave.luau\"
params = { amplitude = 0.1 }
";

const SCRIPT: &str = "local a\nfunction init(robot, params) a = params.amplitude * random() end
function run(robot)\nrobot.set_position(\"left_elbow\", a * math.sin(20 * robot.time))\nend\n";

fn place(scenario: &str, script: &str) -> Place {
    let place = Place::new();
    let hoap2 = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/hoap2/hoap2.toml");
    place.write("s.toml", scenario.replace("HOAP2", hoap2)).write("tasks/wave.luau", script);
    place
}

#[test]
fn check_finds_errors_without_running() {
    for (script, expected) in [
        ("function run(\n", "tasks/wave.luau:2:"),
        ("function runs() end", "tasks/wave.luau: there is no function `run`"),
    ] {
        let place = place(WAVE, script);
        for arguments in [&["check", "s.toml"][..], &["s.toml"]] {
            let done = place.runner(arguments).exits(2);
            assert!(done.stderr.contains(expected) && done.stderr.contains("s.toml:5:8"), "{}", done.stderr);
        }
        assert!(!place.path("results").exists());
    }
    let missing = place(&WAVE.replace("wave.luau", "gone.luau"), SCRIPT);
    let done = missing.runner(&["check", "s.toml"]).exits(2);
    assert!(done.stderr.contains("gone.luau") && done.stderr.contains("s.toml:5:8"), "{}", done.stderr);
}

#[test]
fn an_error_is_the_outcome_of_that_run_alone() {
    let script =
        "function init(robot, params) if params.amplitude > 0.1 then\nerror(\"too far\") end end\nfunction run() end";
    let scenario = format!("{WAVE}[sweep.grid]\n\"task.0.params.amplitude\" = [0.1, 0.2]\n");
    let place = place(&scenario, script);
    place.runner(&["s.toml", "--no-log"]).exits(3);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["passed", "error"]);
    assert!(summary.column("message")[1].contains("tasks/wave.luau:2: too far"), "{:?}", summary.column("message"));
}

#[test]
fn the_script_is_part_of_the_run_key_and_the_log() {
    let place = place(WAVE, SCRIPT);
    let keys = |results: &str| {
        place.runner(&["s.toml", "-o", results]).exits(0);
        place.summary(results).column("key")[0].to_owned()
    };
    let first = keys("a");
    assert_eq!(first, keys("b"));
    place.write("tasks/wave.luau", SCRIPT.replace("20", "21"));
    assert_ne!(first, keys("c"));
    let log = fs::read(place.path("a").join("s").join(&first).join("log.mcap")).unwrap();
    let held = |needle: &[u8]| log.windows(needle.len()).any(|w| w == needle);
    assert!(held(b"wave.luau") && held(SCRIPT.as_bytes()), "attached as it is");
    let record = fs::read_to_string(place.path("a").join("s").join(&first).join("run.json")).unwrap();
    assert!(record.contains("wave.luau"), "hashed");
}

#[test]
fn results_do_not_depend_on_threads() {
    let place = place(&format!("{WAVE}[sweep]\nrepeat = 4\n"), SCRIPT);
    for jobs in ["1", "3"] {
        place.runner(&["s.toml", "-j", jobs, "-o", jobs]).exits(0);
    }
    let keys = place.summary("1").column("key").into_iter().map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(keys.len(), 4);
    let log = |results: &str, key: &str| fs::read(place.path(results).join("s").join(key).join("log.mcap")).unwrap();
    for key in &keys {
        assert!(log("1", key) == log("3", key), "{key}");
    }
    let z = place.summary("1");
    let z = z.column("actuator_work_J");
    assert!(z[0] != z[1] && z[1] != z[2], "seeds matter: {z:?}");
}
