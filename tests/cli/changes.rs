//! Tests of `runner compare`.

use std::fs;

use stiction::compare::Results;

use super::{Done, Place};

/// Two runs of a block that slides.
const SLIDE: &str = "base = { linear_velocity = [1, 0, 0] }\n[sweep.grid]\n\"floor.friction\" = [0.4, 0.8]\n\"integrator.step\" = [1e-3]\n";

fn sliding_blocks() -> Place {
    let place = Place::new();
    place.block("s.toml", SLIDE);
    place.runner(&["s.toml", "--set", "duration=0.5", "--no-log", "-o", "a"]).exits(0);
    place
}

fn last_line(done: &Done) -> &str {
    done.stdout.lines().last().unwrap()
}

#[test]
fn equal_results_agree_in_every_file_format() {
    let place = sliding_blocks();
    place.runner(&["s.toml", "--set", "duration=0.5", "--no-log", "-o", "b", "-j", "1"]).exits(0);
    let same = "2 runs compared: within the tolerances; 0 values beyond tolerance, 0 outcomes changed, 0 runs missing";
    for b in ["b", "b/summary.csv", "b/summary.parquet", "b/runs.jsonl"] {
        // All digits must agree.
        let done = place.runner(&["compare", "a", b, "--absolute", "0", "--relative", "0"]).exits(0);
        assert_eq!(last_line(&done), same, "{b}");
        assert!(!done.stdout.contains("column  "), "no column differs: {}", done.stdout);
    }
}

#[test]
fn compare_reads_the_summary_csv_of_a_folder() {
    let place = sliding_blocks();
    place.runner(&["s.toml", "--set", "duration=0.5", "--no-log", "-o", "b"]).exits(0);
    let text = fs::read_to_string(place.path("b/summary.csv")).unwrap();
    let x = place.summary("b").column("final_base_x")[0].to_owned();
    place.write("b/summary.csv", text.replace(&x, "0.5"));
    let done = place.runner(&["compare", "a", "b"]).exits(1);
    assert!(done.stdout.contains("final_base_x        s floor.friction=0.4"), "{}", done.stdout);
}

#[test]
fn changes_beyond_tolerance_are_reported_by_run_and_column() {
    let place = sliding_blocks();
    place.block("other/s.toml", &SLIDE.replace("[0.4, 0.8]", "[0.4, { static = 0.8, kinetic = 0.79 }]"));
    place.write("other/block/block.toml", fs::read(place.path("block/block.toml")).unwrap());
    place.write("other/block/block.urdf", fs::read(place.path("block/block.urdf")).unwrap());
    place.runner(&["other/s.toml", "--set", "duration=0.5", "--no-log", "-o", "b"]).exits(0);
    // The swept values differ, so these are different runs.
    let done = place.runner(&["compare", "a", "b"]).exits(1);
    assert!(done.stdout.contains("only in A: s floor.friction=0.8 integrator.step=0.001"), "{}", done.stdout);
    assert!(done.stdout.contains("only in B: s floor.friction={ kinetic = 0.79, static = 0.8 }"), "{}", done.stdout);
    // With --set it is the same run with another result.
    let set = ["--set", "duration=0.5", "--set", "robot.base.linear_velocity=[1.001, 0, 0]"];
    place.runner(&[&["s.toml", "--no-log", "-o", "c"], &set[..]].concat()).exits(0);
    let done = place.runner(&["compare", "a", "c"]).exits(1);
    assert!(last_line(&done).starts_with("2 runs compared (0 by their keys): different; "), "{}", done.stdout);
    let cells = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let line = done.stdout.lines().find(|l| l.starts_with("final_base_x ")).map(cells).unwrap();
    let values = |results: &str| place.summary(results).column("final_base_x")[0].to_owned();
    assert_eq!(line[1..4], ["s", "floor.friction=0.4", "integrator.step=0.001"]);
    assert_eq!(line[4..6], [values("a"), values("c")]);
    // Stopping distance v^2 / (2 mu g) for 0.1 % more speed.
    let distance: f64 = line[6].parse().unwrap();
    assert!((distance - 0.002001 / (2.0 * 0.4 * 9.81)).abs() < 1e-5, "{distance}");
    let json = place.runner(&["compare", "a", "c", "--format", "json"]).exits(1);
    let json: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!((json["matched"].as_u64(), json["matched_by_key"].as_u64()), (Some(2), Some(0)));
    let columns: Vec<&str> =
        json["columns"].as_array().unwrap().iter().map(|c| c["column"].as_str().unwrap()).collect();
    assert!(columns.contains(&"final_base_x") && !columns.contains(&"wall_s"), "{columns:?}");
    assert_eq!(place.runner(&["compare", "a", "c", "--relative", "1e6"]).exits(0).code, Some(0));
    let allowed: Vec<String> = columns.iter().flat_map(|c| ["--threshold".into(), format!("{c}=inf")]).collect();
    let allowed: Vec<&str> = allowed.iter().map(String::as_str).collect();
    place.runner(&[&["compare", "a", "c"], &allowed[..]].concat()).exits(0);
    // Thresholds for all columns except the first.
    let done = place.runner(&[&["compare", "a", "c", "--threshold", "final_base_x=1e-6,1e-6"], &allowed[2..]].concat());
    assert!(done.code == Some(1) || columns[0] == "final_base_x", "{}", done.stdout);
}

const HEADER: &str =
    "scenario,key,outcome,message,method,integrator,seed,mu,duration_s,wall_s,real_time_factor,first_slip_s";

/// A summary: [`HEADER`] followed by these rows.
fn summary(rows: &[&str]) -> String {
    [&[HEADER][..], rows].concat().join("\n") + "\n"
}

#[test]
fn rows_are_matched_by_key_then_by_identity() {
    let place = Place::new();
    place.write(
        "a.csv",
        summary(&["s,k1,passed,,exact,dopri5,1,0.10,1.0,1,1,", "s,k2,passed,,exact,dopri5,1,1e-5,2.0,1,1,0.5"]),
    );
    place.write(
        "b.csv",
        summary(&["s,k3,passed,,exact,dopri5,1,0.00001,2.0,1,1,0.5", "s,k1,passed,,exact,dopri5,1,0.2,1.0,1,1,"]),
    );
    let done = place.runner(&["compare", "a.csv", "b.csv"]).exits(0);
    assert!(last_line(&done).starts_with("2 runs compared (1 by their keys): within"), "{}", done.stdout);
    // A run with another method, seed or scenario is a different run.
    for other in
        ["s,k3,passed,,exact,dopri5,2,1e-5", "s,k3,passed,,one-step,dopri5,1,1e-5", "t,k2,passed,,exact,dopri5,1,1e-5"]
    {
        place.write("b.csv", summary(&[&format!("{other},2.0,1,1,0.5"), "s,k1,passed,,exact,dopri5,1,0.1,1.0,1,1,"]));
        let done = place.runner(&["compare", "a.csv", "b.csv"]).exits(1);
        assert!(last_line(&done).ends_with("2 runs missing"), "{}", done.stdout);
    }
}

#[test]
fn outcomes_empty_cells_and_times_are_compared() {
    let place = Place::new();
    place.write("a.csv", summary(&["s,k,passed,,exact,dopri5,1,1,1.0,1.0,4.0,"]));
    let compare = |row: &str, more: &[&str]| {
        place.write("b.csv", summary(&[row]));
        place.runner(&[&["compare", "a.csv", "b.csv"], more].concat())
    };
    let done = compare("s,k,failed,what,exact,dopri5,1,1,1.0,1.0,4.0,", &[]).exits(1);
    assert!(done.stdout.contains("outcome: s mu=1: passed in A, failed in B"), "{}", done.stdout);
    let done = compare("s,k,passed,,exact,dopri5,1,1,1.0,1.0,4.0,0.3", &[]).exits(1);
    assert!(done.stdout.lines().any(|l| l.starts_with("first_slip_s  s mu=1  -  0.3 ")), "{}", done.stdout);
    compare("s,k,passed,,exact,dopri5,1,1,NaN,1.0,4.0,", &[]).exits(1);
    let slow = "s,k,passed,,exact,dopri5,1,1,1.0,1.9,4.0,";
    compare(slow, &[]).exits(0);
    compare(slow, &["--timing", "2"]).exits(0);
    compare(slow, &["--timing", "1.5"]).exits(1);
    compare("s,k,passed,,exact,dopri5,1,1,1.0,0.1,4.0,", &["--timing", "1.5"]).exits(0);
    compare("s,k,passed,,exact,dopri5,1,1,1.0,1.0,2.0,", &["--timing", "1.5"]).exits(1);
    // A column of only one result is reported, not compared.
    place.write(
        "c.csv",
        "scenario,key,outcome,message,method,integrator,seed,mu,steps\ns,k,passed,,exact,dopri5,1,1,7\n",
    );
    let done = place.runner(&["compare", "a.csv", "c.csv"]).exits(0);
    assert!(done.stdout.contains("in one of them only: duration_s, wall_s, real_time_factor, first_slip_s, steps"));
}

#[test]
fn the_last_line_of_a_run_is_used() {
    let place = sliding_blocks();
    place.runner(&["s.toml", "--set", "duration=0.5", "--no-log", "-o", "a"]).exits(0);
    let lines = fs::read_to_string(place.path("a/runs.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 4);
    // As if the last batch was killed while it wrote a line.
    place.write("torn.jsonl", format!("{lines}{{\"scenario\": \"s"));
    let done = place.runner(&["compare", "torn.jsonl", "a"]).exits(0);
    assert!(last_line(&done).starts_with("2 runs compared: within"), "{}", done.stdout);
}

#[test]
fn unreadable_results_exit_with_2_and_empty_results_with_4() {
    let place = sliding_blocks();
    place.write("plain.csv", "x,y\n1,2\n").write("bad.jsonl", "{\n{}\n").write("bad.parquet", "none").write("e/x", "");
    place.write("empty.jsonl", "");
    for (arguments, text) in [
        (&["a", "nowhere"][..], "no such file or folder"),
        (&["a", "s.toml"], "neither a folder of results"),
        (&["a", "e"], "a folder without results"),
        (&["plain.csv", "a"], "it has no column `scenario`"),
        (&["a", "bad.jsonl"], "line 1"),
        (&["a", "bad.parquet"], "bad.parquet: "),
        (&["a", "a", "--threshold", "final_base_q=1"], "did you mean `final_base_"),
        (&["a", "a", "--threshold", "final_base_x"], "COLUMN=ABS[,REL]"),
        (&["a", "a", "--threshold", "final_base_x=-1"], "expected a number of at least 0"),
        (&["a", "a", "--threshold", "method=1"], "neither result has a numeric column `method`"),
        (&["a", "a", "--timing", "0.5"], "expected a number of at least 1"),
        (&["a"], "required"),
    ] {
        let done = place.runner(&[&["compare"], arguments].concat()).exits(2);
        assert!(done.stderr.contains(text), "{arguments:?}: {}", done.stderr);
    }
    let done = place.runner(&["compare", "empty.jsonl", "empty.jsonl"]).exits(4);
    assert!(done.stderr.contains("nothing to compare"), "{}", done.stderr);
    place.runner(&["compare", "empty.jsonl", "a"]).exits(1);
}

/// Results are read row by row: order and format of the files change nothing.
#[test]
fn order_and_format_of_the_files_change_nothing() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 3\n[sweep.grid]\n\"floor.friction\" = [0.1, 0.2, 0.3]\n");
    let run = |output: &str, set: &str| {
        place.runner(&["s.toml", "--no-log", "--set", "duration=0.05", "--set", set, "-o", output]).exits(0)
    };
    run("a", "robot.base.linear_velocity=[1, 0, 0]");
    run("b", "robot.base.linear_velocity=[1.1, 0, 0]");
    let expected = place.runner(&["compare", "a", "b", "--format", "json"]).exits(1).stdout;
    let changes: serde_json::Value = serde_json::from_str(&expected).unwrap();
    assert_eq!((&changes["matched"], &changes["matched_by_key"]), (&9.into(), &0.into()));
    assert!(changes["beyond"].as_array().unwrap().len() >= 9, "{changes}");
    let reversed = |from: &str, to: &str, header: usize| {
        let text = std::fs::read_to_string(place.path(from)).unwrap();
        let mut lines: Vec<&str> = text.lines().collect();
        lines[header..].reverse();
        place.write(to, lines.join("\n") + "\n");
    };
    reversed("b/summary.csv", "b.csv", 1);
    reversed("b/runs.jsonl", "b.jsonl", 0);
    for a in ["a/summary.csv", "a/summary.parquet"] {
        for b in ["b/summary.csv", "b/summary.parquet", "b.csv"] {
            assert_eq!(place.runner(&["compare", a, b, "--format", "json"]).exits(1).stdout, expected, "{a} {b}");
        }
    }
    // The order of lines is that in which runs ended, and numbers are written as JSON.
    let sorted = |a: &str, b: &str| {
        let text = place.runner(&["compare", a, b, "--format", "json"]).exits(1).stdout;
        let changes: serde_json::Value = serde_json::from_str(&text).unwrap();
        let field = |d: &serde_json::Value, name: &str| d[name].as_str().unwrap().to_owned();
        let beyond = changes["beyond"].as_array().unwrap().iter();
        let mut found: Vec<_> =
            beyond.map(|d| (field(d, "run"), field(d, "column"), d["distance"].as_f64().map(f64::to_bits))).collect();
        found.sort();
        found
    };
    let reference = sorted("a", "b");
    assert_eq!(sorted("a/runs.jsonl", "b/runs.jsonl"), reference);
    assert_eq!(sorted("a/runs.jsonl", "b.jsonl"), reference);
    assert_eq!(sorted("a/runs.jsonl", "b/summary.parquet"), reference);
}

#[test]
fn damaged_lists_and_tables_are_refused() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 3\n");
    place.runner(&["s.toml", "--no-log", "--set", "duration=0.05"]).exits(0);
    let list = std::fs::read_to_string(place.path("results/runs.jsonl")).unwrap();
    let lines: Vec<&str> = list.lines().collect();
    let damaged = lines[1].replacen("\"duration_s\":0.05", "\"duration_s\":0.07", 1);
    assert_ne!(damaged, lines[1]);
    place.write("damaged.jsonl", [lines[0], &damaged, lines[2]].join("\n") + "\n");
    let done = place.runner(&["compare", "damaged.jsonl", "results"]).exits(2);
    assert!(done.stderr.contains("damaged.jsonl: line 2: damaged: its content does not match"), "{}", done.stderr);
    // Lines of earlier versions have no checksum.
    let without = |line: &str| format!("{}}}", line.rsplit_once(",\"checksum\"").unwrap().0);
    place.write("earlier.jsonl", lines.iter().map(|line| without(line) + "\n").collect::<String>());
    place.runner(&["compare", "earlier.jsonl", "results"]).exits(0);
    let table = std::fs::read_to_string(place.path("results/summary.csv")).unwrap();
    place.write("short.csv", table.replacen(",passed,", ",", 1));
    let done = place.runner(&["compare", "short.csv", "results"]).exits(2);
    assert!(done.stderr.contains("short.csv: row 1: found "), "{}", done.stderr);
}

/// The library for tables panics at some damaged files; 1 % of these changes cause it.
#[test]
fn damaged_tables_are_read_or_refused() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 2\n");
    place.runner(&["s.toml", "--no-log", "--set", "duration=0.01"]).exits(0);
    let table = std::fs::read(place.path("results/summary.parquet")).unwrap();
    let path = place.path("damaged.parquet");
    let mut refused = 0;
    for at in (4..table.len()).step_by(table.len() / 1500) {
        let mut damaged = table.clone();
        damaged[at] ^= 0xff;
        std::fs::write(&path, &damaged).unwrap();
        match Results::open(&path) {
            Ok(mut results) => {
                let mut row = results.blank_row();
                (0..results.len()).for_each(|position| results.read(position, &mut row).unwrap());
            }
            Err(error) => {
                assert!(error.to_string().contains("damaged.parquet: "), "{error}");
                refused += 1;
            }
        }
    }
    assert!(refused > 500, "{refused}");
}
