//! More runs than are kept in memory.

use std::fs::{self, File};

use polars_io::SerReader;
use polars_io::parquet::read::ParquetReader;
use stiction::results::SAMPLE_SIZE;

use super::Place;
use crate::same::rows;

#[test]
fn runs_that_are_not_kept_are_in_the_summary_in_their_order() {
    let place = Place::new();
    let runs = SAMPLE_SIZE + 60;
    // One of them does not end as it should, long after memory is full.
    place.block(
        "s.toml",
        &format!(
            "[log]\nrate = 0\n[[expect]]\nmetric = \"duration_s\"\nmax = 0.0015\n[sweep]\nzip = [{{ seed = {{ linspace = [1, {runs}, {runs}] }}, duration = [{}0.002, 0.001] }}]\n",
            "0.001, ".repeat(runs - 2)
        ),
    );
    let most = (runs + 1).to_string();
    let arguments = ["s.toml", "--max-runs", &most];
    place.runner(&arguments[..1]).exits(2);
    let done = place.runner(&arguments).exits(1);
    assert!(done.stdout.contains(&format!("{runs} runs: {} passed, 1 failed", runs - 1)), "{}", done.stdout);
    assert!(done.stdout.contains("duration_s is 0.002, above 0.0015"), "those that went wrong are shown");
    assert!(done.stdout.lines().count() < 100, "and no others: {} lines", done.stdout.lines().count());
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
    assert!(page.contains(&format!("{runs} runs of 1 scenario")), "the numbers are of all");
    assert!(page.contains("60 more runs are counted here"), "and it says what is not shown");
    assert!(page.len() < 4 << 20, "{} bytes", page.len());
    // Read back from records they are the same rows.
    let before = rows(&table);
    let done = place.runner(&[&arguments[..], &["--resume"]].concat()).exits(1);
    assert!(done.stderr.contains(&format!("resumed: {runs} runs done already")), "{}", done.stderr);
    assert_eq!(rows(&place.summary("results")), before);
    // `report` does not have them all in memory either, and says the same of them.
    place.runner(&["report", "results"]).exits(0);
    assert_eq!(rows(&place.summary("results")), before);
    let page = fs::read_to_string(place.path("results/report.html")).unwrap();
    assert!(page.contains(&format!("{runs} runs of 1 scenario")) && page.contains("60 more runs are counted here"));
    // Also without a summary that says in which order they stood: by what was swept.
    fs::remove_file(place.path("results/summary.csv")).unwrap();
    place.runner(&["report", "results"]).exits(0);
    let mut durations = place.summary("results").numbers("duration_s");
    assert_eq!(durations.pop(), Some(0.002), "by `duration`, the only one that is longer");
    assert!(durations.len() == runs - 1 && durations.iter().all(|duration| *duration < 0.0015));
}
