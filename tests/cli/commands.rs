//! Tests of `list`, `check`, `inspect`, `schema` and `--set`.

use std::io::Read;
use std::process::Stdio;

use super::{Done, Place, Table};

const SWEEP: &str =
    "[sweep]\ngrid = { \"contact.method\" = [\"exact\", \"one-step\"], \"floor.friction\" = [0.2, 0.4] }\n";

#[test]
fn list_prints_the_runs_in_three_formats() {
    let place = Place::new();
    place.block("rest.toml", "").block("slide.toml", SWEEP);
    let arguments = |format| ["list", "--format", format, "rest.toml", "slide.toml"];
    let csv = Table::parse(&place.runner(&arguments("csv")).exits(0).stdout);
    assert_eq!(csv.header, ["scenario", "key", "seed", "contact.method", "floor.friction"]);
    assert_eq!(csv.column("scenario"), ["rest", "slide", "slide", "slide", "slide"]);
    assert_eq!(csv.column("contact.method"), ["", "exact", "exact", "one-step", "one-step"]);
    assert_eq!(csv.column("floor.friction"), ["", "0.2", "0.4", "0.2", "0.4"]);

    let json: serde_json::Value = serde_json::from_str(&place.runner(&arguments("json")).exits(0).stdout).unwrap();
    let keys: Vec<&str> = json.as_array().unwrap().iter().map(|run| run["key"].as_str().unwrap()).collect();
    assert_eq!(keys, csv.column("key"));
    assert_eq!(json[4]["parameters"]["contact.method"], "one-step");
    assert_eq!(json[4]["parameters"]["floor.friction"], 0.4);
    assert_eq!(json[4]["file"], "slide.toml");

    let text = place.runner(&arguments("text")).exits(0).stdout;
    let line = text.lines().nth(4).unwrap();
    assert!(line.starts_with("slide") && line.contains(keys[4]), "{line}");
    assert!(line.ends_with("contact.method=one-step floor.friction=0.4"), "{line}");
    assert!(!place.path("results").exists(), "listing runs nothing");
}

#[test]
fn list_distinguishes_repetitions_by_seed() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 3\n");
    let text = place.runner(&["list", "s.toml"]).exits(0).stdout;
    let ends: Vec<&str> = text.lines().map(|l| l.rsplit(' ').next().unwrap()).collect();
    assert_eq!(ends, ["seed=1", "seed=2", "seed=3"]);
}

#[test]
fn check_counts_runs_and_writes_no_files() {
    let place = Place::new();
    place.block("in/rest.toml", "").block("in/slide.toml", SWEEP).write("in/notes.md", "not a scenario");
    for name in ["rest", "slide"] {
        let path = place.path(&format!("in/{name}.toml"));
        let text = std::fs::read_to_string(&path).unwrap().replace("block/", "../block/");
        std::fs::write(path, text).unwrap();
    }
    let done = place.runner(&["check", "in"]).exits(0);
    assert!(done.stdout.ends_with("all good: 2 scenarios, 5 runs\n"), "{}", done.stdout);
    assert_eq!(done.stderr, "");
    assert!(!place.path("results").exists());
}

/// The error is at the swept value; `run` refuses the batch too.
#[test]
fn a_start_below_the_floor_is_refused_where_it_is_swept() {
    let place = Place::new();
    let sweep = "base = { position = [0, 0, 1] }\n[sweep]\ngrid = { \"robot.base.position.2\" = [0.05, 0.02] }\n";
    place.block("s.toml", sweep);
    for arguments in [&["check", "s.toml"][..], &["s.toml"]] {
        let done = place.runner(arguments).exits(2);
        let text = "sole `bottom` of link `block` starts 0.0300 m below the floor, with the base at z = 0.02 m";
        assert!(done.stderr.contains(text) && done.stderr.contains("s.toml:5:43"), "{}", done.stderr);
    }
    assert!(!place.path("results").exists());
}

#[test]
fn set_replaces_values_and_fixes_swept_ones() {
    let place = Place::new();
    place.block("slide.toml", SWEEP);
    let list = |set: &[&str]| {
        let arguments: Vec<&str> = ["list", "--format", "csv", "slide.toml"].iter().chain(set).copied().collect();
        Table::parse(&place.runner(&arguments).exits(0).stdout)
    };
    let plain = list(&[]);
    let fixed = list(&["--set", "contact.method=one-step"]);
    assert_eq!(fixed.column("contact.method"), ["one-step", "one-step"]);
    assert_eq!(fixed.column("key"), &plain.column("key")[2..], "--set selects runs with the same keys");
    let other = list(&["--set", "contact.method=one-step", "--set", "duration=1.5"]);
    assert_ne!(other.column("key"), fixed.column("key"));
}

#[test]
fn inspect_describes_robots_and_refuses_other_files() {
    let place = Place::new();
    let done = place.runner(&["inspect", "block/block.toml"]).exits(0);
    assert!(done.stdout.starts_with("robot block\n"), "{}", done.stdout);
    assert!(done.stdout.contains("degrees of freedom  6 (6 base, 0 joints)"), "{}", done.stdout);
    assert!(done.stdout.contains("soles (1)"), "{}", done.stdout);
    let done = place.runner(&["inspect", "block/block.urdf"]).exits(0);
    assert!(done.stdout.contains("soles (1)"), "a bare URDF's soles are found: {}", done.stdout);
    place.write("broken.urdf", "<robot name=\"x\">\n  <link name=\"a\">\n</robot>\n");
    let done = place.runner(&["inspect", "broken.urdf"]).exits(2);
    assert!(done.stderr.contains("broken.urdf:3:"), "{}", done.stderr);
    place.runner(&["inspect", "nowhere.urdf"]).exits(2);
}

#[test]
fn schema_prints_the_schemas_of_the_library() {
    let place = Place::new();
    let schema = |format| -> serde_json::Value {
        serde_json::from_str(&place.runner(&["schema", format]).exits(0).stdout).unwrap()
    };
    let scenario = schema("scenario");
    assert_eq!(scenario, stiction::scenario::schema());
    assert!(scenario["properties"]["contact"].is_object());
    let robot = schema("robot");
    assert_eq!(robot, stiction::robot::schema());
    assert!(robot["properties"]["sole"].is_object());
}

#[test]
fn help_lists_exactly_the_existing_commands() {
    let place = Place::new();
    let help = place.runner(&["--help"]).exits(0).stdout;
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|l| *l != "Commands:")
        .skip(1)
        .take_while(|l| !l.is_empty())
        .filter_map(|l| l.split_whitespace().next())
        .collect();
    let expected = "run check list inspect convert report merge submit compare export fit salvage replay motor-server console view schema completions man help";
    assert_eq!(commands.join(" "), expected);
}

#[test]
fn a_closed_output_pipe_is_no_error() {
    let place = Place::new();
    // More text than a pipe buffers, so the program writes to the closed pipe.
    place.block("s.toml", "[sweep]\nrepeat = 3000\n");
    let mut child = place.command(&["list", "s.toml"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = [0; 10];
    child.stdout.as_mut().unwrap().read_exact(&mut first).unwrap();
    drop(child.stdout.take());
    let done = Done::from(child.wait_with_output().unwrap()).exits(0);
    assert_eq!(done.stderr, "");

    place.block("one.toml", "");
    let mut child = place
        .command(&["one.toml", "--set", "duration=0.1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(place.summary("results").column("outcome"), ["passed"]);
}
