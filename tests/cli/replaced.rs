//! Tests of output files named by the user: the program refuses to overwrite unrelated files.

use std::fs;

use super::Place;

const SWEEP: &str = "[sweep]\ngrid = { \"floor.friction\" = [0.2, 0.4] }\n";

/// A scenario with results, and the folder of one of its runs.
fn with_results() -> (Place, String) {
    let place = Place::new();
    place.block("s.toml", SWEEP);
    place.runner(&["s.toml", "--set", "duration=0.05", "-o", "r"]).exits(0);
    let run = fs::read_dir(place.path("r/s")).unwrap().next().unwrap().unwrap();
    let run = format!("r/s/{}", run.file_name().into_string().unwrap());
    (place, run)
}

#[test]
fn inputs_and_records_are_not_overwritten() {
    let (place, run) = with_results();
    let (record, log) = (format!("{run}/run.json"), format!("{run}/log.mcap"));
    let batch = ["s.toml", "--set", "duration=0.05", "-o", "r2", "--junit"];
    let session = ["console", "s.toml", "--filter", "floor.friction.static == 0.2", "-c", "run 0.1"];
    let saved = ["-c", "save session s.toml"];
    for arguments in [
        ["report", "r", "-o", &record].as_slice(),
        &["report", "r", "-o", "r/summary.csv"],
        &["view", &run, "-o", "s.toml"],
        &["view", &run, "-o", &record],
        &["export", &run, "-o", &record, "--format", "csv"],
        &["export", &run, "-o", "r/summary.csv"],
        &["export", &run, "-o", "s.toml", "--format", "gnuplot"],
        &[&batch[..], &["s.toml"]].concat(),
        &[&batch[..], &[log.as_str()]].concat(),
        &[&session[..], &["--save", "s.toml"]].concat(),
        &[&session[..], &saved[..]].concat(),
    ] {
        let file = arguments.iter().rev().find(|word| **word != "--format" && **word != "csv" && **word != "gnuplot");
        let path = place.path(file.unwrap().trim_start_matches("save session "));
        let before = fs::read(&path).unwrap();
        let done = place.runner(arguments).exits(2);
        assert!(done.stderr.contains("choose another file to write"), "{arguments:?}: {}", done.stderr);
        assert!(fs::read(&path).unwrap() == before, "{arguments:?}");
    }
    assert!(!place.path("r2").exists(), "no run starts if the test results cannot be written");
}

#[test]
fn earlier_output_files_are_overwritten() {
    let (place, run) = with_results();
    let session =
        ["console", "s.toml", "--filter", "floor.friction.static == 0.2", "-c", "run 0.1", "--save", "k.toml"];
    for arguments in [
        ["report", "r", "-o", "page.html"].as_slice(),
        &["view", &run, "-o", "run.html"],
        &["export", &run, "-o", "t.csv"],
        &["export", &run, "-o", "t.parquet"],
        &["s.toml", "--set", "duration=0.05", "-o", "r", "--junit", "j.xml"],
        &session,
    ] {
        place.runner(arguments).exits(0);
        place.runner(arguments).exits(0);
    }
}

#[test]
fn test_results_refuse_folders_and_files_of_the_results() {
    let place = Place::new();
    place.block("s.toml", SWEEP);
    for junit in ["r", "r/s", "r/../r", "r/summary.csv", "r/runs.jsonl", "block"] {
        let done = place.runner(&["s.toml", "--set", "duration=0.05", "-o", "r", "--junit", junit]).exits(2);
        assert!(done.stderr.contains(&format!("{junit}: is a f")), "{}", done.stderr);
        assert!(!place.path("r/s").exists(), "{junit}");
    }
}

/// Each record contains the swept values, so a summary of re-runs has the same columns.
#[test]
fn replayed_runs_keep_their_swept_values() {
    let (place, _) = with_results();
    place.runner(&["replay", "r", "-o", "again"]).exits(0);
    place.runner(&["report", "again"]).exits(0);
    let mut both = ["r", "again"].map(|folder| {
        let table = place.summary(folder);
        let mut rows: Vec<String> = table.column("floor.friction").iter().map(|cell| cell.to_string()).collect();
        rows.sort();
        rows
    });
    assert_eq!(both[0], ["0.2", "0.4"]);
    assert_eq!(std::mem::take(&mut both[1]), both[0]);
    let done = place.runner(&["s.toml", "--set", "duration=0.05", "-o", "again", "--resume"]).exits(0);
    assert!(done.stderr.contains("resumed: 2 runs done already"), "{}", done.stderr);
}
