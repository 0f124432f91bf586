//! Tests of `--resume`: which runs are reused, which are re-run, and the stated reasons.

use std::fs;

use stiction::results::RunRecord;

use super::{ARGUMENTS, EXIT_CODE, batch};
use crate::cli::{Done, Place};
use crate::support::same::assert_same;

fn resume(place: &Place, arguments: &[&str]) -> Done {
    place.runner(&[arguments, &["--resume"]].concat())
}

/// The line with the reason for re-runs.
#[track_caller]
fn rerun_reason(done: &Done) -> &str {
    let mut lines = done.stderr.lines().filter(|line| line.contains(" again: "));
    let line = lines.next().unwrap_or_else(|| panic!("no reason in {}", done.stderr));
    assert_eq!(lines.next(), None, "{}", done.stderr);
    line.trim()
}

#[test]
fn resumed_batch_reruns_only_missing_runs() {
    let place = batch();
    place.runner(&[&ARGUMENTS[..], &["-o", "whole"]].concat()).exits(EXIT_CODE);
    place.runner(&ARGUMENTS).exits(EXIT_CODE);
    let modified = |place: &Place| {
        let key = place.summary("results").column("key")[0].to_owned();
        fs::metadata(place.path("results/thrown").join(key).join("run.json")).unwrap().modified().unwrap()
    };
    let before = modified(&place);
    let done = resume(&place, &ARGUMENTS).exits(EXIT_CODE);
    assert!(done.stderr.contains("resumed: 16 runs and 4 reference runs done already"), "{}", done.stderr);
    assert!(!done.stderr.contains("[1") && !done.stderr.contains("again"), "no run starts: {}", done.stderr);
    assert_eq!(modified(&place), before);
    assert_same(&place.path("whole"), &place.path("results"));
    // One record is missing: only its run and the reference that it needs are re-run.
    let keys: Vec<String> = place.summary("results").column("key").iter().map(|k| k.to_string()).collect();
    fs::remove_file(place.path("results/slides").join(&keys[12]).join("run.json")).unwrap();
    let done = resume(&place, &[&ARGUMENTS[..], &["-v"]].concat()).exits(EXIT_CODE);
    assert!(done.stderr.contains("resumed: 15 runs and 3 reference runs done already"), "{}", done.stderr);
    assert!(done.stderr.contains("1 run for the first time"), "{}", done.stderr);
    let lines: Vec<&str> = done.stderr.lines().filter(|l| l.starts_with('[')).collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines[1].starts_with("[20/20] slides "), "{lines:?}");
    // The list has a second line of this run. That is the only difference.
    let listed = fs::read_to_string(place.path("results/runs.jsonl")).unwrap();
    assert_eq!(listed.lines().count(), 17);
    let first_lines: Vec<&str> = listed.lines().take(16).collect();
    place.write("results/runs.jsonl", first_lines.join("\n") + "\n");
    assert_same(&place.path("whole"), &place.path("results"));
}

#[test]
fn a_removed_reference_is_rerun() {
    let place = batch();
    place.runner(&[&ARGUMENTS[..], &["-o", "whole"]].concat()).exits(EXIT_CODE);
    place.runner(&ARGUMENTS).exits(EXIT_CODE);
    fs::remove_dir_all(place.path("results/slides/references")).unwrap();
    let done = resume(&place, &ARGUMENTS).exits(EXIT_CODE);
    assert!(done.stderr.contains("resumed: 16 runs done already"), "{}", done.stderr);
    assert!(done.stderr.contains("again: its record is missing, "), "{}", done.stderr);
    assert_same(&place.path("whole"), &place.path("results"));
}

/// The key depends on the resolved scenario, so two sweeps can contain the same run. Its row has
/// the columns of its own sweep.
#[test]
fn a_run_of_another_sweep_is_rerun() {
    let place = Place::new();
    let grid = |more: &str| format!("[sweep.grid]\n\"floor.friction\" = [0.4, 0.5]\n{more}");
    place.block("s.toml", &grid(""));
    let batch = |folder| ["s.toml", "--set", "duration=0.01", "-o", folder];
    place.runner(&batch("results")).exits(0);
    // The default value and another one.
    place.block("s.toml", &grid("\"integrator.relative_tolerance\" = [1e-6, 1e-8]\n"));
    place.runner(&batch("whole")).exits(0);
    let done = resume(&place, &batch("results")).exits(0);
    assert!(rerun_reason(&done).contains("2 runs again: other values are swept now"), "{}", done.stderr);
    let column = |folder: &str| {
        let summary = place.summary(folder);
        summary.column("integrator.relative_tolerance").iter().map(|x| x.to_string()).collect::<Vec<_>>()
    };
    assert_eq!(column("results"), column("whole"));
    assert!(column("results").iter().all(|x| !x.is_empty()));
}

/// Changes each kind of input and checks the stated reason.
#[test]
fn changed_inputs_are_stated_as_the_reason() {
    let place = Place::new();
    let home = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = |from: &str, to: &str| fs::read_to_string(home.join(from)).map(|text| place.write(to, text).path(to));
    copy("robots/hoap2/hoap2.toml", "hoap2/hoap2.toml").unwrap();
    let urdf = copy("robots/hoap2/hoap2.urdf", "hoap2/hoap2.urdf").unwrap();
    copy("scenarios/motions/bow.toml", "bow.toml").unwrap();
    copy("scenarios/tasks/wave.luau", "wave.luau").unwrap();
    let mesh = "solid m\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid m\n";
    place.write("hoap2/badge.stl", mesh);
    let shape = "<visual><geometry><mesh filename=\"badge.stl\" scale=\"0.01 0.01 0.01\"/></geometry></visual>";
    let text = fs::read_to_string(&urdf).unwrap();
    let text = text.replacen("<collision>", &format!("{shape}<collision>"), 1);
    assert!(text.contains(shape));
    place.write("hoap2/hoap2.urdf", &text);
    let scenario = |friction: &str| {
        place.write(
            "s.toml",
            format!(
                "duration = 0.02\n[robot]\nmodel = \"hoap2/hoap2.toml\"\n[floor]\nfriction = {friction}
[[task]]\ntype = \"playback\"\nfile = \"bow.toml\"
[[task]]\ntype = \"script\"\nfile = \"wave.luau\"\nparams = {{ amplitude = 0.3, frequency = 1.0, duration = 3.5 }}
[sweep.grid]\n\"integrator.max_step\" = [0.01, 0.005]\n"
            ),
        );
    };
    let change = |file: &str, from: &str, to: &str| {
        let text = fs::read_to_string(place.path(file)).unwrap();
        assert!(text.contains(from), "{file}");
        place.write(file, text.replacen(from, to, 1));
    };
    let resume_reason = || {
        let done = resume(&place, &["s.toml"]);
        assert!(matches!(done.code, Some(0)), "{}", done.stderr);
        rerun_reason(&done).strip_suffix(", such as s integrator.max_step=0.01").unwrap().to_owned()
    };
    scenario("0.5");
    let first = resume(&place, &["s.toml"]).exits(0);
    assert!(first.stderr.contains("  2 runs for the first time"), "{}", first.stderr);
    scenario("0.6");
    assert_eq!(
        resume_reason(),
        "2 runs again: `floor.friction.kinetic` was 0.5, is 0.6; `floor.friction.static` was 0.5, is 0.6"
    );
    change("hoap2/hoap2.toml", "\n", "\n# A note.\n");
    assert_eq!(resume_reason(), "2 runs again: robot file hoap2.toml changed");
    change("hoap2/hoap2.urdf", "<visual>", "<!-- A note. --><visual>");
    assert_eq!(resume_reason(), "2 runs again: robot file hoap2.urdf changed");
    change("hoap2/badge.stl", "vertex 1 0 0", "vertex 2 0 0");
    assert_eq!(resume_reason(), "2 runs again: mesh badge.stl changed");
    change("bow.toml", "HOAP-2 bows", "It bows");
    assert_eq!(resume_reason(), "2 runs again: `task.0.file`, the file bow.toml changed");
    change("wave.luau", "Raises", "Lifts");
    change("s.toml", "duration", "gravity = [0, 0, -9.8]\nduration");
    assert_eq!(
        resume_reason(),
        "2 runs again: `gravity` was [0.0, 0.0, -9.81], is [0.0, 0.0, -9.8]; `task.1.file`, the file wave.luau changed"
    );
    // Records as written by another version of the program.
    let last: Vec<String> = place.summary("results").column("key").iter().map(|key| key.to_string()).collect();
    for entry in fs::read_dir(place.path("results/s")).unwrap() {
        let folder = entry.unwrap().path();
        if !last.iter().any(|key| folder.ends_with(key)) {
            fs::remove_dir_all(folder).unwrap();
            continue;
        }
        let mut record = RunRecord::read(&folder.join("run.json")).unwrap();
        let other: String = record.key.chars().rev().collect();
        (record.program, record.key) = ("stiction 0.0.9".into(), other.clone());
        record.write(&folder.with_file_name(other).join("run.json")).unwrap();
        fs::remove_dir_all(folder).unwrap();
    }
    assert_eq!(
        resume_reason(),
        format!("2 runs again: the program was stiction 0.0.9, is {}", stiction::results::PROGRAM)
    );
}

#[test]
fn timed_out_runs_are_rerun_and_failed_runs_are_not() {
    let place = Place::new();
    // The first run ends before the required duration, the third exceeds the time limit.
    place.block(
        "s.toml",
        "[log]\nrate = 1\n[[expect]]\nmetric = \"duration_s\"\nmin = 0.1\n[sweep.grid]\nduration = [0.05, 0.1, 1e8]\n",
    );
    place.runner(&["s.toml", "--timeout", "1", "-j", "1"]).exits(3);
    assert_eq!(place.summary("results").column("outcome"), ["failed", "passed", "timed-out"]);
    let key = place.summary("results").column("key")[2].to_owned();
    assert!(place.path("results/s").join(&key).join("log.mcap").is_file(), "an unfinished run keeps its log");
    let done = resume(&place, &["s.toml", "--timeout", "1", "-j", "1"]).exits(3);
    assert_eq!(rerun_reason(&done), "1 run again: it ended as `timed-out`, s duration=100000000.0");
    assert!(done.stderr.contains("resumed: 2 runs done already"), "{}", done.stderr);
    // A failed expectation would fail again, so the run is reused. The exit code is still 1.
    let done = resume(&place, &["s.toml", "--set", "duration=0.05"]).exits(1);
    assert!(done.stderr.contains("resumed: 1 run done already"), "{}", done.stderr);
}

#[test]
fn missing_or_damaged_files_cause_a_rerun() {
    let place = Place::new();
    place.block("s.toml", "");
    let arguments = ["s.toml", "--set", "duration=0.1"];
    place.runner(&[&arguments[..], &["--no-log"]].concat()).exits(0);
    let done = resume(&place, &arguments).exits(0);
    assert_eq!(rerun_reason(&done), "1 run again: it has no log, s");
    let key = place.summary("results").column("key")[0].to_owned();
    let run = |name: &str| place.path("results/s").join(&key).join(name);
    assert!(run("log.mcap").is_file());
    // An incomplete log or record, as after a power failure.
    let log = fs::read(run("log.mcap")).unwrap();
    fs::write(run("log.mcap"), &log[..log.len() / 2]).unwrap();
    assert_eq!(
        rerun_reason(&resume(&place, &arguments).exits(0)),
        "1 run again: its log is shorter than the recorded one, s"
    );
    assert_eq!(fs::read(run("log.mcap")).unwrap(), log);
    fs::remove_file(run("log.mcap")).unwrap();
    assert_eq!(rerun_reason(&resume(&place, &arguments).exits(0)), "1 run again: its log is missing, s");
    // A changed byte in the middle, with the same length and end.
    let mut damaged = log.clone();
    damaged[log.len() / 2] ^= 1;
    fs::write(run("log.mcap"), &damaged).unwrap();
    let done = resume(&place, &arguments).exits(0);
    assert_eq!(rerun_reason(&done), "1 run again: its log is not the recorded one, s");
    assert_eq!(fs::read(run("log.mcap")).unwrap(), log);
    // Records of earlier versions have no hash of the log. Then only the end of the log is checked.
    let mut record: serde_json::Value = serde_json::from_slice(&fs::read(run("run.json")).unwrap()).unwrap();
    assert!(record.as_object_mut().unwrap().remove("log").is_some());
    fs::write(run("run.json"), record.to_string()).unwrap();
    assert!(resume(&place, &arguments).exits(0).stderr.contains("resumed: 1 run done already"));
    fs::write(run("log.mcap"), &log[..log.len() / 2]).unwrap();
    assert_eq!(rerun_reason(&resume(&place, &arguments).exits(0)), "1 run again: its log is incomplete, s");
    fs::write(run("run.json"), "{").unwrap();
    assert_eq!(rerun_reason(&resume(&place, &arguments).exits(0)), "1 run again: its record is incomplete, s");
    // A changed digit leaves valid JSON.
    let text = fs::read_to_string(run("run.json")).unwrap();
    let damaged = text.replacen("\"duration_s\": 0.1", "\"duration_s\": 0.2", 1);
    assert_ne!(text, damaged);
    fs::write(run("run.json"), damaged).unwrap();
    let done = resume(&place, &arguments).exits(0);
    assert_eq!(rerun_reason(&done), "1 run again: its record is damaged, s");
    let mut record = RunRecord::read(&run("run.json")).unwrap();
    record.key = "0123456789abcdef".into();
    record.write(&run("run.json")).unwrap();
    assert_eq!(rerun_reason(&resume(&place, &arguments).exits(0)), "1 run again: its record belongs to another run, s");
    // Timing repetitions are not part of the key: the run is reused and timed.
    place.block("s.toml", "[compare]\ntiming_repeats = 2\n");
    let done = resume(&place, &arguments).exits(0);
    assert!(done.stderr.contains("resumed: 1 run done already"), "{}", done.stderr);
    assert!(place.summary("results").numbers("timing_cpu_min_s")[0] > 0.0);
    assert!(!resume(&place, &arguments).exits(0).stderr.contains("timing: repetition"), "an existing timing is reused");
}
