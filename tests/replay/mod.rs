//! Tests of `runner replay`: a re-run gives the same bits, and differences are reported.

use crate::cli::{Done, Place};
use serde_json::Value;
use std::fs;

/// The block falls, slides and comes to rest; compared with a finer run, judged, swept and
/// repeated.
const FALL: &str = r#"
base = { position = [0, 0, 0.06], linear_velocity = [1, 0, 0], rpy = [0.1, 0, 0] }
[floor]
friction = 0.3
[log]
rate = 100
[compare]
reference = { "integrator.relative_tolerance" = 1e-9 }
[[expect]]
metric = "final_base_x"
min = 0.0
[[force]]
type = "random-pushes"
links = ["block"]
number = 3
magnitude = [0.5, 1.0]
push_duration = [0.02, 0.02]
[sweep]
repeat = 2
[sweep.grid]
"contact.method" = ["exact", "one-step"]
"#;

/// Folders of the runs of a scenario.
fn folders(place: &Place, scenario: &str) -> Vec<String> {
    let entries = fs::read_dir(place.path("results").join(scenario)).unwrap();
    let names = entries.map(|e| e.unwrap().file_name().to_str().unwrap().to_owned());
    let mut found: Vec<_> = names.filter(|n| n != "references").map(|n| format!("results/{scenario}/{n}")).collect();
    found.sort();
    found
}

fn finished_sweep() -> Place {
    let place = Place::new();
    place.block("in/fall.toml", FALL);
    fs::rename(place.path("block"), place.path("in/block")).unwrap();
    place.runner(&["in/fall.toml", "--set", "duration=0.5"]).exits(0);
    place
}

/// One run without comparison.
fn finished_run() -> (Place, String) {
    let place = Place::new();
    // With fixed steps, a longer run is equal up to the end of the shorter one.
    let text = "base = { linear_velocity = [1, 0, 0] }\n[log]\nrate = 100\n[integrator]\nmethod = \"rk4\"\n";
    place.block("slide.toml", text);
    place.runner(&["slide.toml", "--set", "duration=0.3"]).exits(0);
    let folder = folders(&place, "slide").remove(0);
    (place, folder)
}

/// Changes the record of a run.
fn tamper(place: &Place, folder: &str, change: impl FnOnce(&mut Value)) {
    let path = place.path(folder).join("run.json");
    let mut record = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    change(&mut record);
    fs::write(&path, serde_json::to_vec(&record).unwrap()).unwrap();
}

#[track_caller]
fn assert_prints(done: &Done, text: &str) {
    assert!(done.stdout.contains(text) || done.stderr.contains(text), "{}\n{}", done.stdout, done.stderr);
}

#[test]
fn every_run_of_a_sweep_gives_the_same_bits() {
    let place = finished_sweep();
    let before = fs::read(place.path("results/summary.csv")).unwrap();
    let done = place.runner(&["replay", "results"]).exits(0);
    // Four runs and the references they were compared with: one for each method and seed.
    let runs = done.stdout.matches(": same bits (run.json and log.mcap)").count();
    let references = done.stdout.matches(": same bits (run.json; there is no log)").count();
    assert_eq!((runs, references), (4, 4), "{}", done.stdout);
    assert_prints(&done, "8 runs gave the same bits, 0 did not");
    assert_eq!(fs::read(place.path("results/summary.csv")).unwrap(), before, "the results are unchanged");
    // The scenario file may be missing or changed, because the record contains the scenario.
    fs::remove_file(place.path("in/fall.toml")).unwrap();
    let key = folders(&place, "fall")[0].rsplit('/').next().unwrap().to_owned();
    assert_prints(&place.runner(&["replay", &key[..8]]).exits(0), "same bits");
}

#[test]
fn output_keeps_the_results_of_a_rerun() {
    let (place, folder) = finished_run();
    place.runner(&["replay", &folder, "-o", "again"]).exits(0);
    let again = place.path(&folder.replace("results", "again"));
    let logs = [place.path(&folder), again].map(|f| fs::read(f.join("log.mcap")).unwrap());
    assert!(logs[0] == logs[1]);
    let done = place.runner(&["replay", &folder, "-o", "results"]).exits(2);
    assert_prints(&done, "would be written over");
}

#[test]
fn base_gives_the_folder_of_relative_paths() {
    let (place, folder) = finished_run();
    fs::create_dir(place.path("other")).unwrap();
    let from =
        |arguments: &[&str]| Done::from(place.command(arguments).current_dir(place.path("other")).output().unwrap());
    let folder = format!("../{folder}");
    let lost = from(&["replay", &folder]).exits(2);
    assert_prints(&lost, "block.toml");
    assert_prints(
        &lost,
        "its scenario was slide.toml, which does not exist in this directory: run this command where the batch was started",
    );
    assert_prints(&from(&["replay", &folder, "--base", ".."]).exits(0), "same bits");
    tamper(&place, &folder[3..], |record| drop(record["timing"].as_object_mut().unwrap().remove("file")));
    assert_prints(&from(&["replay", &folder]).exits(2), "--base FOLDER");
    assert_prints(&from(&["replay", &folder, "--base", ".."]).exits(0), "same bits");
}

#[test]
fn a_changed_metric_is_reported_with_both_values() {
    let (place, folder) = finished_run();
    let mut was = String::new();
    tamper(&place, &folder, |record| {
        let x = &mut record["metrics"]["final_base_position"][0];
        was = x.to_string();
        // The next representable number.
        *x = f64::from_bits(x.as_f64().unwrap().to_bits() + 1).into();
    });
    let done = place.runner(&["replay", &folder]).exits(1);
    assert_prints(&done, ": differs");
    assert_prints(&done, "run.json: metrics.final_base_position.0: ");
    assert_prints(&done, &format!(" then, {was} now\n"));
    tamper(&place, &folder, |record| record["outcome"] = "fallen".into());
    assert_prints(&place.runner(&["replay", &folder]).exits(1), "(and 1 more value)");
}

#[test]
fn a_changed_log_is_reported_at_its_first_difference() {
    let (place, folder) = finished_run();
    // The log of a run with another initial speed, and of one that ends later.
    let log = place.path(&folder).join("log.mcap");
    let other = |override_: &str| {
        place.runner(&["slide.toml", "--set", "duration=0.3", "--set", override_, "-o", "other"]).exits(0);
        let entry = fs::read_dir(place.path("other/slide")).unwrap().next().unwrap().unwrap().path();
        fs::copy(entry.join("log.mcap"), &log).unwrap();
        fs::remove_dir_all(place.path("other")).unwrap();
        place.runner(&["replay", &folder]).exits(1)
    };
    let done = other("robot.base.linear_velocity=[1.5, 0, 0]");
    assert_prints(&done, "log.mcap: at 0.0 s, `base_vx_m_s`: 1.5 then, 1.0 now");
    let done = other("duration=0.4");
    assert_prints(&done, "log.mcap: from 0.31 s on: 41 ticks then, 31 ticks now");
    // Equal motion, another scenario: only the attached text differs.
    let done = other("description=\"another\"");
    assert_prints(&done, "log.mcap: attached text: slide.toml then");
    let mut bytes = fs::read(&log).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&log, bytes).unwrap();
    assert_prints(&place.runner(&["replay", &folder]).exits(1), "damaged");
}

#[test]
fn changed_inputs_are_named() {
    let (place, folder) = finished_run();
    let path = place.path("block/block.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{text}\n# a remark\n")).unwrap();
    let done = place.runner(&["replay", &folder]).exits(0);
    assert_prints(&done, "warning: slide ");
    assert_prints(&done, "block.toml has changed since");
    assert_prints(&done, "same values despite the changes");
    let urdf = place.path("block/block.urdf");
    let heavier = fs::read_to_string(&urdf).unwrap();
    let mass = heavier.split("<mass value=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
    fs::write(&urdf, heavier.replace(&format!("<mass value=\"{mass}\""), &format!("<mass value=\"{mass}1\""))).unwrap();
    let done = place.runner(&["replay", &folder]).exits(1);
    assert_prints(&done, "block.urdf has changed since");
    assert_prints(&done, "differs");
    fs::remove_file(&urdf).unwrap();
    assert_prints(&place.runner(&["replay", &folder]).exits(2), "block.urdf");
}

#[test]
fn a_changed_scenario_in_the_record_is_detected() {
    let (place, folder) = finished_run();
    tamper(&place, &folder, |record| {
        let text = record["resolved"].as_str().unwrap().replace("duration = 0.3", "duration = 0.2");
        record["resolved"] = text.into();
    });
    let done = place.runner(&["replay", &folder]).exits(1);
    assert_prints(&done, "the scenario in the record is not the one that was run");
    tamper(&place, &folder, |record| record["resolved"] = "robot = 1".into());
    assert_prints(&place.runner(&["replay", &folder]).exits(2), "the run cannot be re-run");
    tamper(&place, &folder, |record| record["program"] = "stiction 0.0.1".into());
    fs::write(place.path(&folder).join("run.json"), "{}").unwrap();
    place.runner(&["replay", &folder]).exits(2);
}

#[test]
fn another_program_is_named() {
    let (place, folder) = finished_run();
    tamper(&place, &folder, |record| record["program"] = "stiction 0.0.1".into());
    let done = place.runner(&["replay", &folder]).exits(0);
    assert_prints(&done, "it was run by stiction 0.0.1, this is stiction ");
}

#[test]
fn another_build_is_named_and_the_bits_are_compared() {
    let (place, folder) = finished_run();
    let mut build = String::new();
    tamper(&place, &folder, |record| {
        build = record["timing"]["build"].as_str().unwrap().to_owned();
        record["timing"]["build"] = "0123456789abcdef".into();
    });
    assert!(build.len() == 16 && build == stiction::results::BUILD, "{build}");
    let done = place.runner(&["replay", &folder]).exits(0);
    assert_prints(&done, &format!("it was run by another build of this version, 0123456789abcdef, this is {build}"));
    assert_prints(&done, "same bits (run.json and log.mcap)");
    let resumed = place.runner(&["slide.toml", "--set", "duration=0.3", "--resume"]).exits(0);
    assert_prints(&resumed, "resumed: 1 run done already\n  1 run of these by another build of this version");
}

#[test]
fn contact_problems_are_written_to_the_output_folder() {
    let (place, folder) = finished_run();
    place.runner(&["replay", &folder, "--dump-problems=all"]).exits(2);
    place.runner(&["replay", &folder, "--dump-problems=all", "-o", "again"]).exits(0);
    let again = place.path("again").join(folder.strip_prefix("results/").unwrap());
    let problems = fs::read_dir(again.join("problems")).unwrap().count();
    assert!(problems > 0, "a block that slides and stops selects states");
    place.runner(&["slide.toml", "--set", "duration=0.3", "--dump-problems=all", "-o", "first"]).exits(0);
    let first = place.path("first").join(folder.strip_prefix("results/").unwrap()).join("problems");
    assert_eq!(fs::read_dir(&first).unwrap().count(), problems);
    let bytes = |folder: &std::path::Path| fs::read(folder.join("0001.json")).unwrap();
    assert_eq!(bytes(&first), bytes(&again.join("problems")));
}

#[test]
fn a_timed_out_run_is_compared_up_to_its_end() {
    let place = Place::new();
    place.block("long.toml", "base = { linear_velocity = [1, 0, 0] }\n[log]\nrate = 100\n");
    place.runner(&["long.toml", "--set", "duration=1e6", "--timeout", "0.05"]).exits(3);
    let folder = folders(&place, "long").remove(0);
    let log = fs::read(place.path(&folder).join("log.mcap"));
    let done = place.runner(&["replay", &folder, "--timeout", "3"]).exits(0);
    match log {
        Ok(_) => assert_prints(&done, "same bits up to the external termination"),
        Err(_) => assert_prints(&done, "nothing to compare"),
    }
}

/// Records that cannot be read are not among those that gave the same bits.
#[test]
fn damaged_records_of_a_folder_are_reported() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 3\n");
    place.runner(&["s.toml", "--no-log", "--set", "duration=0.02"]).exits(0);
    let all = folders(&place, "s");
    fs::write(place.path(&all[0]).join("run.json"), "{}").unwrap();
    let done = place.runner(&["replay", "results"]).exits(2);
    assert!(done.stderr.contains("error: not re-run: ") && done.stderr.contains(&all[0]), "{}", done.stderr);
    assert_prints(&done, "2 runs gave the same bits, 0 did not, 1 run not re-run");
    // Other runs do not matter to one that is named.
    place.runner(&["replay", &all[1]]).exits(0);
}

#[test]
fn unknown_and_ambiguous_keys_are_refused() {
    let (place, folder) = finished_run();
    assert_prints(
        &place.runner(&["replay", "0000000000000000"]).exits(2),
        "no run below results has a key that begins with",
    );
    assert_prints(&place.runner(&["replay", "x", "--results", "nowhere"]).exits(2), "nowhere");
    place.runner(&["slide.toml", "--set", "duration=0.1"]).exits(0);
    assert_prints(&place.runner(&["replay", ""]).exits(2), "is the beginning of several keys");
    assert_prints(&place.runner(&["replay", &format!("{folder}/run.json")]).exits(0), "same bits");
    fs::create_dir(place.path("empty")).unwrap();
    assert_prints(&place.runner(&["replay", "empty"]).exits(4), "nothing selected");
    place.runner(&["replay"]).exits(2);
}

#[test]
fn a_missing_log_is_reported() {
    let (place, folder) = finished_run();
    fs::remove_file(place.path(&folder).join("log.mcap")).unwrap();
    let done = place.runner(&["replay", &folder]).exits(1);
    assert!(done.stdout.contains("log.mcap: the log is missing, although the record has its hash"), "{}", done.stdout);
}

#[test]
fn a_reached_time_limit_prevents_the_comparison_of_that_run_only() {
    let (place, folder) = finished_run();
    let done = place.runner(&["replay", &folder, "--timeout", "1e-9"]).exits(3);
    assert_prints(&done, "not finished within --timeout, stopped at ");
    assert!(!done.stdout.contains("differs") && !done.stdout.contains("same bits"), "{}", done.stdout);
    // A run that cannot be re-run does not prevent the others.
    place.block("other.toml", "");
    place.runner(&["other.toml", "--set", "duration=0.1"]).exits(0);
    tamper(&place, &folder, |record| drop(record["timing"].as_object_mut().unwrap().remove("file")));
    let done = place.runner(&["replay", "results"]).exits(2);
    assert_prints(&done, "--base FOLDER");
    assert_prints(&done, "1 run gave the same bits, 0 did not, 1 run not re-run");
}
