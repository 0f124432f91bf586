//! Tests that a summary belongs to the last batch, or does not exist.

use super::{ARGUMENTS, EXIT_CODE, batch};
use crate::cli::Place;
use crate::support::same::assert_same;

const SUMMARY: [&str; 3] = ["summary.csv", "summary.parquet", "report.html"];

#[test]
fn a_failed_batch_leaves_no_summary_of_an_earlier_batch() {
    let place = batch();
    place.runner(&ARGUMENTS).exits(EXIT_CODE);
    assert!(SUMMARY.iter().all(|name| place.path("results").join(name).is_file()));
    // No space for the line of the first finished run.
    let limited = format!("trap '' XFSZ; ulimit -f 0; exec \"$0\" {}", ARGUMENTS.join(" "));
    let done = place.shell(&limited);
    assert_eq!(done.code, Some(3), "{}", done.stderr);
    for name in SUMMARY {
        assert!(!place.path("results").join(name).exists(), "{name} is that of the previous batch");
    }
}

#[test]
fn two_programs_do_not_write_into_the_same_folder() {
    let place = Place::new();
    place.block("s.toml", "");
    std::fs::create_dir(place.path("results")).unwrap();
    let _lock = stiction::results::RunsLog::append(&place.path("results/runs.jsonl")).unwrap();
    place.write("results/summary.csv", "theirs");
    for more in [&[][..], &["--resume"]] {
        let done = place.runner(&[&["s.toml"][..], more].concat()).exits(2);
        assert!(done.stderr.contains("another runner is using these results"), "{}", done.stderr);
    }
    assert_eq!(std::fs::read_to_string(place.path("results/summary.csv")).unwrap(), "theirs");
}

#[test]
fn durable_results_are_the_same() {
    let place = batch();
    place.runner(&["thrown.toml", "--no-log"]).exits(0);
    place.runner(&["thrown.toml", "--no-log", "--durable", "-o", "deep/durable"]).exits(0);
    assert_same(&place.path("results"), &place.path("deep/durable"));
    place.runner(&["thrown.toml", "--no-log", "--durable", "--shard", "1/1", "-o", "part"]).exits(0);
    place.runner(&["merge", "part", "--durable", "-o", "merged"]).exits(0);
    assert_same(&place.path("results"), &place.path("merged"));
}
