//! Tests of a full disk: a clear error, and finished runs are kept.
#![cfg(unix)]

use std::fs;

use super::{ARGUMENTS, EXIT_CODE, assert_all_files_complete, batch};
use crate::cli::Place;
use crate::same::assert_same;

/// Runs the program with a limit on the size of files. The limit is in blocks of the shell, of 512
/// or 1024 bytes. A write beyond the limit fails, as on a full disk.
fn run_with_file_size_limit(place: &Place, blocks: u32, arguments: &[&str]) -> crate::cli::Done {
    place.shell(&format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" {}", arguments.join(" ")))
}

#[test]
fn a_full_disk_ends_the_batch_and_resume_completes_it() {
    let place = batch();
    place.runner(&[&ARGUMENTS[..], &["--no-log", "-o", "whole"]].concat()).exits(EXIT_CODE);
    let arguments = [&ARGUMENTS[..], &["--no-log", "-o", "small"]].concat();
    // Enough for each record of some 8 kB, and for a few lines of `runs.jsonl` of some 2 kB each.
    let done = run_with_file_size_limit(&place, 24, &arguments).exits(3);
    assert!(done.stderr.contains("error: small/runs.jsonl: File too large"), "{}", done.stderr);
    assert!(done.stderr.contains("with --resume"), "{}", done.stderr);
    let results = place.path("small");
    assert_all_files_complete(&results);
    let lines = fs::read_to_string(results.join("runs.jsonl")).unwrap();
    assert!((1..16).contains(&lines.lines().count()) && lines.ends_with('\n'), "{lines}");
    place.runner(&[&arguments[..], &["--resume"]].concat()).exits(EXIT_CODE);
    assert_same(&place.path("whole"), &results);
}

#[test]
fn a_log_beyond_the_disk_space_is_an_error_of_its_run_only() {
    let place = Place::new();
    place.block("s.toml", "[sweep.grid]\nduration = [0.1, 30.0, 0.2]\n");
    // One second of log takes some 20 kB.
    let done = run_with_file_size_limit(&place, 128, &["s.toml", "-j", "1"]).exits(3);
    assert!(done.stderr.contains("log.mcap: File too large"), "{}", done.stderr);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["passed", "error", "passed"]);
    assert_all_files_complete(&place.path("results"));
    let done = place.runner(&["s.toml", "-j", "1", "--resume"]).exits(0);
    assert!(done.stderr.contains("1 run again: it ended as `error`, s duration=30"), "{}", done.stderr);
    assert_eq!(place.summary("results").column("outcome"), ["passed"; 3]);
}

#[test]
fn a_batch_stops_if_a_run_cannot_be_listed() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 50\n");
    // Enough for a record, and for the lines of some runs.
    let done =
        run_with_file_size_limit(&place, 24, &["s.toml", "--set", "duration=0.1", "-j", "1", "--no-log"]).exits(3);
    assert!(done.stderr.contains("results/runs.jsonl: File too large"), "{}", done.stderr);
    assert!(done.stderr.contains("finished runs remain in results"), "{}", done.stderr);
    // Also runs started before the error was handled: one, or more if the processor is busy.
    let finished = fs::read_dir(place.path("results/s")).unwrap().count();
    assert!((1..50).contains(&finished), "{finished} runs");
}
