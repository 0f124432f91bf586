//! Tests of the default output: one line per scenario, failed runs, marked runs, no wrapped lines.

use super::{Done, Place};

fn run_at_width(place: &Place, columns: &str, arguments: &[&str], code: i32) -> Done {
    Done::from(place.command(arguments).env("COLUMNS", columns).output().unwrap()).exits(code)
}

#[test]
fn the_default_output_has_one_line_per_scenario_and_the_failed_runs() {
    let place = Place::new();
    let runs = "[[expect]]\nmetric = \"duration_s\"\nmax = 0.0295\n[sweep]\ngrid = { duration = { linspace = [1e-3, 0.03, 30] } }\n";
    place.block("many.toml", runs).block("one.toml", "[sweep]\ngrid = { duration = [0.01] }\n");
    let done = run_at_width(&place, "80", &["many.toml", "one.toml"], 1);
    let lines: Vec<&str> = done.stdout.lines().collect();
    assert!(lines.len() < 24, "the output fits a screen:\n{}", done.stdout);
    let cells = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
    assert_eq!(cells(lines[0]), "scenario runs outcomes held sim s cpu s");
    assert!(cells(lines[1]).starts_with("many 30 29 passed, 1 failed 29 of 30 "), "{}", lines[1]);
    assert!(cells(lines[2]).starts_with("one 1 passed - "), "{}", lines[2]);
    assert_eq!(lines[4], "31 runs: 30 passed, 1 failed; 29 of 30 expectations held");
    assert!(lines[6].contains("(duration=0.03): duration_s is 0.03, above 0.0295"), "{}", lines[6]);
    // Without a terminal, progress has about ten lines, and one for each failed run.
    let progress = done.stderr.lines().filter(|line| line.starts_with('[')).count();
    assert!((10..=15).contains(&progress), "{}", done.stderr);
    let verbose = run_at_width(&place, "80", &["many.toml", "one.toml", "-v"], 1);
    assert_eq!(verbose.stderr.lines().filter(|line| line.starts_with('[')).count(), 31, "{}", verbose.stderr);
    assert_eq!(verbose.stdout.matches("/run.json\n").count(), 31);
}

#[test]
fn tables_fit_the_width() {
    let place = Place::new();
    let sweep = "[[expect]]\nmetric = \"max_flight_spin_drift_Nms\"\nvalue = 0\ntolerance = 1\n[sweep.grid]\n\
                 duration = [0.01, 0.02]\n\"floor.friction\" = [0.123456, { static = 0.5, kinetic = 0.4 }]\n\
                 \"robot.base.linear_velocity\" = [[0.1, 0.2, 0.3]]\n";
    place.block("a-scenario-with-quite-a-long-name.toml", sweep);
    for columns in ["80", "100", "200"] {
        let width: usize = columns.parse().unwrap();
        let file = ["a-scenario-with-quite-a-long-name.toml", "--verdicts", "all", "-v"];
        let done = run_at_width(&place, columns, &file, 0);
        let tables = done.stdout.split("\nwritten:").next().unwrap();
        assert!(tables.lines().all(|line| line.chars().count() <= width), "{columns}\n{tables}");
        assert!(tables.contains("a-scena") && tables.contains("x real"), "{tables}");
        assert!(tables.contains("measured  expected"), "{tables}");
    }
}

#[test]
fn a_run_whose_base_ends_below_the_floor_is_marked() {
    let place = Place::new();
    // Upside down, the sole is above the base, and the floor does not stop the base.
    place.block("drop.toml", "contact = \"soles\"\nbase = { position = [0, 0, 0.2], rpy = [\"180 deg\", 0, 0] }\n");
    place.block("tilted.toml", "[floor]\nrpy = [0, \"20 deg\", 0]\nheight = -3\n");
    let done = run_at_width(
        &place,
        "80",
        &["drop.toml", "tilted.toml", "--set", "duration=1", "--set", "stop.sunk_link=ignore"],
        0,
    );
    assert_eq!(done.stdout.matches("implausible").count(), 1, "{}", done.stdout);
    assert!(done.stdout.contains("\n! drop ") && done.stdout.contains("\ntilted "), "{}", done.stdout);
    assert!(done.stdout.contains(": implausible: at its end the base is 0.050 m below the floor\n"), "{}", done.stdout);
}
