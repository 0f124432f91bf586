//! Tests of batches with more runs than are kept in memory.

use std::fs::{self, File};

use polars_io::SerReader;
use polars_io::parquet::read::ParquetReader;
use stiction::results::SAMPLE_SIZE;

use super::Place;
use crate::support::same::rows;

#[test]
fn the_summary_has_all_runs_in_plan_order_beyond_the_memory_sample() {
    let place = Place::new();
    let runs = SAMPLE_SIZE + 60;
    // One run fails long after the sample of runs in memory is full.
    place.block(
        "s.toml",
        &format!(
            "[log]\nrate = 0\n[[expect]]\nmetric = \"duration_s\"\nmax = 0.0015\n[sweep]\nzip = [{{ seed = {{ linspace = [1, {runs}, {runs}] }}, duration = [{}0.002, 0.001] }}]\n",
            "0.001, ".repeat(runs - 2)
        ),
    );
    let max_runs = (runs + 1).to_string();
    let arguments = ["s.toml", "--max-runs", &max_runs];
    place.runner(&arguments[..1]).exits(2);
    let done = place.runner(&arguments).exits(1);
    assert!(done.stdout.contains(&format!("{runs} runs: {} passed, 1 failed", runs - 1)), "{}", done.stdout);
    assert!(done.stdout.contains("duration_s is 0.002, above 0.0015"), "failed runs are shown");
    assert!(done.stdout.lines().count() < 100, "no other runs are shown: {} lines", done.stdout.lines().count());
    let table = place.summary("results");
    let seeds: Vec<String> = (1..=runs).map(|seed| seed.to_string()).collect();
    assert_eq!(table.column("seed"), seeds);
    let outcomes = table.column("outcome");
    assert_eq!(outcomes.iter().position(|outcome| *outcome == "failed"), Some(runs - 2));
    let parquet = File::open(place.path("results/summary.parquet")).unwrap();
    let frame = ParquetReader::new(parquet).finish().unwrap();
    assert_eq!(frame.height(), runs);
    assert_eq!(frame.column("seed").unwrap().u64().unwrap().get(runs - 1), Some(runs as u64));
    let page = fs::read_to_string(place.path("results/report.html")).unwrap();
    assert!(page.contains(&format!("{runs} runs of 1 scenario")), "the counts include all runs");
    assert!(page.contains("60 more runs are counted here"), "the page states the number of omitted runs");
    assert!(page.len() < 4 << 20, "{} bytes", page.len());
    // A resumed batch reads the same rows from the records.
    let before = rows(&table);
    let done = place.runner(&[&arguments[..], &["--resume"]].concat()).exits(1);
    assert!(done.stderr.contains(&format!("resumed: {runs} runs done already")), "{}", done.stderr);
    assert_eq!(rows(&place.summary("results")), before);
    // `report` keeps only a sample in memory too, and writes the same rows.
    place.runner(&["report", "results"]).exits(0);
    assert_eq!(rows(&place.summary("results")), before);
    let page = fs::read_to_string(place.path("results/report.html")).unwrap();
    assert!(page.contains(&format!("{runs} runs of 1 scenario")) && page.contains("60 more runs are counted here"));
    // Without an earlier summary, rows are ordered by the swept values.
    fs::remove_file(place.path("results/summary.csv")).unwrap();
    place.runner(&["report", "results"]).exits(0);
    let mut durations = place.summary("results").numbers("duration_s");
    assert_eq!(durations.pop(), Some(0.002), "the only longer duration is last");
    assert!(durations.len() == runs - 1 && durations.iter().all(|duration| *duration < 0.0015));
}
