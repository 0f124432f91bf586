//! Tests that nothing is written outside the folder of results: symbolic links in it are refused or
//! replaced, never followed.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use crate::cli::Place;
use crate::support::same::files;

/// Creates a folder next to the results with two files, one named like a record.
fn create_elsewhere(place: &Place) {
    place.write("elsewhere/run.json", "mine").write("elsewhere/keep.txt", "mine");
}

#[track_caller]
fn assert_elsewhere_unchanged(place: &Place) {
    let folder = place.path("elsewhere");
    assert_eq!(files(&folder), ["keep.txt", "run.json"]);
    for file in files(&folder) {
        assert_eq!(fs::read_to_string(folder.join(file)).unwrap(), "mine");
    }
}

/// Runs the block for a tenth of a second and returns the folder of the run within the results.
fn run(place: &Place) -> String {
    place.block("s.toml", "");
    place.runner(&["s.toml", "--set", "duration=0.1"]).exits(0);
    let found = files(&place.path("results"));
    found.iter().find_map(|f| f.strip_suffix("/run.json")).unwrap().to_owned()
}

fn is_plain_file(path: &Path) -> bool {
    fs::symlink_metadata(path).unwrap().is_file()
}

#[test]
fn a_link_as_folder_of_a_scenario_is_refused() {
    for name in ["s", "s/references"] {
        let place = Place::new();
        create_elsewhere(&place);
        place.block("s.toml", "");
        fs::create_dir_all(place.path("results").join(name).parent().unwrap()).unwrap();
        symlink(place.path("elsewhere"), place.path("results").join(name)).unwrap();
        let done = place.runner(&["s.toml"]).exits(2);
        let message = format!("results/{name}: a symbolic link to {}", place.path("elsewhere").display());
        assert!(done.stderr.contains(&message), "{}", done.stderr);
        assert_elsewhere_unchanged(&place);
    }
}

#[test]
fn a_link_as_folder_of_a_run_is_an_error_of_that_run() {
    let place = Place::new();
    create_elsewhere(&place);
    let folder = run(&place);
    fs::remove_dir_all(place.path("results").join(&folder)).unwrap();
    symlink(place.path("elsewhere"), place.path("results").join(&folder)).unwrap();
    let done = place.runner(&["s.toml", "--set", "duration=0.1"]).exits(3);
    assert!(done.stdout.contains(&format!("results/{folder}: a symbolic link to")), "{}", done.stdout);
    assert_eq!(place.summary("results").column("outcome"), ["error"]);
    assert_elsewhere_unchanged(&place);
}

#[test]
fn a_link_as_list_of_runs_is_refused() {
    for target in ["elsewhere/keep.txt", "elsewhere/new.txt"] {
        let place = Place::new();
        create_elsewhere(&place);
        place.block("s.toml", "");
        fs::create_dir(place.path("results")).unwrap();
        symlink(place.path(target), place.path("results/runs.jsonl")).unwrap();
        let done = place.runner(&["s.toml"]).exits(2);
        assert!(done.stderr.contains("results/runs.jsonl: a symbolic link to"), "{}", done.stderr);
        assert_elsewhere_unchanged(&place);
    }
}

#[test]
fn links_as_result_files_are_replaced_by_files() {
    let place = Place::new();
    create_elsewhere(&place);
    let folder = run(&place);
    let names: Vec<String> = ["summary.csv", "summary.parquet", "report.html"]
        .map(str::to_owned)
        .into_iter()
        .chain(["run.json", "log.mcap"].map(|name| format!("{folder}/{name}")))
        .collect();
    for name in &names {
        let path = place.path("results").join(name);
        fs::remove_file(&path).unwrap();
        // Following a link to a missing file would create that file.
        let target = if name.ends_with("html") { "elsewhere/new.html" } else { "elsewhere/keep.txt" };
        symlink(place.path(target), &path).unwrap();
    }
    symlink(place.path("elsewhere"), place.path("results").join(&folder).join("problems")).unwrap();
    place.runner(&["s.toml", "--set", "duration=0.1", "--dump-problems=all"]).exits(0);
    for name in &names {
        assert!(is_plain_file(&place.path("results").join(name)), "{name}");
    }
    let problems = place.path("results").join(&folder).join("problems");
    assert!(fs::symlink_metadata(problems).unwrap().is_dir());
    assert_elsewhere_unchanged(&place);
    // `report` writes some of these files too.
    for name in &names[..3] {
        let path = place.path("results").join(name);
        fs::remove_file(&path).unwrap();
        symlink(place.path("elsewhere/keep.txt"), &path).unwrap();
    }
    place.runner(&["report", "results"]).exits(0);
    assert_elsewhere_unchanged(&place);
}

#[test]
fn the_folder_of_the_results_may_be_a_link() {
    let place = Place::new();
    fs::create_dir(place.path("there")).unwrap();
    symlink("there", place.path("results")).unwrap();
    run(&place);
    assert!(place.path("there/summary.csv").is_file());
}

/// Two shards of a sweep.
fn shards() -> Place {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 4\n");
    for i in 1..=2 {
        let (shard, output) = (format!("{i}/2"), format!("shard-{i}"));
        place.runner(&["s.toml", "--set", "duration=0.01", "--shard", &shard, "-o", &output]).exits(0);
    }
    place
}

const MERGE: [&str; 5] = ["merge", "shard-1", "shard-2", "-o", "merged"];

#[test]
fn merging_follows_neither_links_nor_invalid_names() {
    let place = shards();
    create_elsewhere(&place);
    fs::create_dir(place.path("merged")).unwrap();
    symlink(place.path("elsewhere"), place.path("merged/s")).unwrap();
    let done = place.runner(&MERGE).exits(2);
    assert!(done.stderr.contains("merged/s: a symbolic link to"), "{}", done.stderr);
    assert_elsewhere_unchanged(&place);
    fs::remove_file(place.path("merged/s")).unwrap();
    let list = place.path("shard-1/shard.jsonl");
    let text = fs::read_to_string(&list).unwrap();
    for name in ["..", "../elsewhere", "/tmp", "", "s/references"] {
        // Lines after the first are runs.
        let (head, runs) = text.split_once('\n').unwrap();
        fs::write(&list, format!("{head}\n{}", runs.replace("\"s\"", &format!("{name:?}")))).unwrap();
        let done = place.runner(&MERGE).exits(2);
        assert!(done.stderr.contains(&format!("\"{name}\" is not a valid folder name")), "{}", done.stderr);
        assert_elsewhere_unchanged(&place);
    }
    // Keys that would be folders of several runs.
    let (head, runs) = text.split_once('\n').unwrap();
    let key = runs.split_once("\"key\":\"").unwrap().1[..16].to_owned();
    for name in ["references", "3f", "..", "0123456789abcdeg"] {
        fs::write(&list, format!("{head}\n{}", runs.replace(&key, name))).unwrap();
        let done = place.runner(&MERGE).exits(2);
        assert!(done.stderr.contains(&format!("\"{name}\" is not a valid folder name")), "{}", done.stderr);
    }
    fs::write(&list, text).unwrap();
    place.runner(&MERGE).exits(0);
}

#[test]
fn merging_copies_regular_files_only() {
    let place = shards();
    create_elsewhere(&place);
    let folder = files(&place.path("shard-1")).into_iter().find(|f| f.ends_with("run.json")).unwrap();
    let folder = Path::new(&folder).parent().unwrap();
    symlink(place.path("elsewhere/keep.txt"), place.path("shard-1").join(folder).join("link.txt")).unwrap();
    symlink(place.path("elsewhere"), place.path("shard-1").join(folder).join("link")).unwrap();
    place.runner(&MERGE).exits(0);
    assert!(place.path("merged").join(folder).join("run.json").is_file());
    let names = fs::read_dir(place.path("merged").join(folder)).unwrap().count();
    assert_eq!(names, 2, "the record and the log");
}

#[test]
fn a_record_cannot_choose_the_output_folder_of_its_replay() {
    let place = Place::new();
    let folder = run(&place);
    let path = place.path("results").join(&folder).join("run.json");
    let text = fs::read_to_string(&path).unwrap();
    for name in ["..", "../../elsewhere", "/tmp/elsewhere"] {
        fs::write(&path, text.replacen("\"scenario\": \"s\"", &format!("\"scenario\": {name:?}"), 1)).unwrap();
        place.runner(&["replay", &format!("results/{folder}"), "--base", ".", "-o", "again/below"]);
        let entries: Vec<String> =
            fs::read_dir(place.path("")).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        assert!(!entries.contains(&"elsewhere".to_owned()), "{entries:?}");
        if place.path("again").exists() {
            assert!(fs::read_dir(place.path("again")).unwrap().all(|e| e.unwrap().file_name() == "below"), "{name}");
        }
    }
}

#[test]
fn long_and_unusual_names_are_folders_or_refused() {
    for stem in ["a b", "ä", "-x", "a\nb", "a\\b", "~", "...", &"n".repeat(250)] {
        let place = Place::new();
        let name = format!("{stem}.toml");
        place.block(&name, "");
        let done = place.runner(&["--set", "duration=0.01", "--no-log", "--", &name]);
        assert_eq!(done.code, Some(0), "{name:?}: {}", done.stderr);
        assert!(place.path("results").join(stem).is_dir(), "{stem:?}");
    }
    for name in ["..toml", "...toml"] {
        let place = Place::new();
        place.block(name, "");
        let done = place.runner(&[name]);
        assert!(!place.path("results").exists() || done.code == Some(0), "{name}: {}", done.stderr);
        assert!(!place.path("summary.csv").exists() && !place.path("run.json").exists(), "{name}");
    }
}

#[test]
fn inputs_behind_links_to_other_folders_are_reported() {
    let place = Place::new();
    place.write("shared/wave.luau", "function run() end\n").write("scenarios/s.toml", "");
    fs::create_dir(place.path("scenarios/tasks")).unwrap();
    place.write("scenarios/tasks/plain.luau", "function run() end\n");
    symlink(place.path("shared/wave.luau"), place.path("scenarios/tasks/wave.luau")).unwrap();
    symlink("plain.luau", place.path("scenarios/tasks/inside.luau")).unwrap();
    let scenario = |script: &str| {
        let text = format!("robot.model = \"../block/block.toml\"\n[[task]]\ntype = \"script\"\nfile = \"{script}\"\n");
        place.write("scenarios/s.toml", text);
    };
    for script in ["tasks/plain.luau", "tasks/inside.luau", "../shared/wave.luau"] {
        scenario(script);
        place.runner(&["check", "--strict", "scenarios/s.toml"]).exits(0);
    }
    scenario("tasks/wave.luau");
    let done = place.runner(&["check", "scenarios/s.toml"]).exits(0);
    let real = place.path("shared/wave.luau").canonicalize().unwrap();
    let message = format!("a symbolic link leads elsewhere: scenarios/tasks/wave.luau is {}", real.display());
    assert!(done.stderr.contains(&message) && done.stderr.contains("scenarios/s.toml:4:8"), "{}", done.stderr);
    place.runner(&["check", "--strict", "scenarios/s.toml"]).exits(2);
    // A robot whose URDF is a link to another folder.
    fs::rename(place.path("block/block.urdf"), place.path("shared/block.urdf")).unwrap();
    symlink(place.path("shared/block.urdf"), place.path("block/block.urdf")).unwrap();
    scenario("tasks/plain.luau");
    let done = place.runner(&["check", "scenarios/s.toml"]).exits(0);
    assert!(done.stderr.contains("a symbolic link leads out of the robot's folder"), "{}", done.stderr);
}

/// A link to a missing scenario is an error: it is not skipped.
#[test]
fn a_link_to_a_missing_scenario_is_an_error() {
    let place = Place::new();
    place.block("in/s.toml", "");
    fs::rename(place.path("block"), place.path("in/block")).unwrap();
    place.runner(&["check", "in"]).exits(0);
    symlink("nowhere.toml", place.path("in/t.toml")).unwrap();
    let done = place.runner(&["check", "in"]).exits(2);
    assert!(done.stderr.contains("in/t.toml"), "{}", done.stderr);
}
