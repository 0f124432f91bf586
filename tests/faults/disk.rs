//! No room, or a folder that cannot be written: a clear error, and what was written is kept.
#![cfg(unix)]

use std::fs;

use super::{ARGUMENTS, ENDS, batch, everything_is_whole};
use crate::cli::Place;
use crate::same::assert_same;

/// The program with files of at most so many blocks (of 512 or 1024 bytes, as the shell has it). A write beyond fails, as on
/// a full disk.
fn with_files_of(place: &Place, blocks: u32, arguments: &[&str]) -> crate::cli::Done {
    place.shell(&format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" {}", arguments.join(" ")))
}

#[test]
fn no_more_room_ends_the_batch_and_the_rest_is_made_when_there_is() {
    let place = batch();
    place.runner(&[&ARGUMENTS[..], &["--no-log", "-o", "whole"]].concat()).exits(ENDS);
    let arguments = [&ARGUMENTS[..], &["--no-log", "-o", "small"]].concat();
    // Room for every record, of some 8 kB, and for a few of the lines of `runs.jsonl`, of some 2 kB.
    let done = with_files_of(&place, 24, &arguments).exits(3);
    assert!(done.stderr.contains("error: small/runs.jsonl: File too large"), "{}", done.stderr);
    assert!(done.stderr.contains("with --resume"), "{}", done.stderr);
    let results = place.path("small");
    everything_is_whole(&results);
    let lines = fs::read_to_string(results.join("runs.jsonl")).unwrap();
    assert!((1..16).contains(&lines.lines().count()) && lines.ends_with('\n'), "{lines}");
    place.runner(&[&arguments[..], &["--resume"]].concat()).exits(ENDS);
    assert_same(&place.path("whole"), &results);
}

#[test]
fn a_log_that_has_no_room_is_an_error_of_its_run_alone() {
    let place = Place::new();
    place.block("s.toml", "[sweep.grid]\nduration = [0.1, 30.0, 0.2]\n");
    // A second of log takes some 20 kB.
    let done = with_files_of(&place, 128, &["s.toml", "-j", "1"]).exits(3);
    assert!(done.stderr.contains("log.mcap: File too large"), "{}", done.stderr);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["passed", "error", "passed"]);
    everything_is_whole(&place.path("results"));
    let done = place.runner(&["s.toml", "-j", "1", "--resume"]).exits(0);
    assert!(done.stderr.contains("1 run again: it ended as `error`, s duration=30"), "{}", done.stderr);
    assert_eq!(place.summary("results").column("outcome"), ["passed"; 3]);
}

#[test]
fn a_batch_goes_no_further_than_the_run_that_could_not_be_told_of() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 50\n");
    // Room for a record, and for the lines of some of the runs.
    let done = with_files_of(&place, 24, &["s.toml", "--set", "duration=0.1", "-j", "1", "--no-log"]).exits(3);
    assert!(done.stderr.contains("results/runs.jsonl: File too large"), "{}", done.stderr);
    assert!(done.stderr.contains("runs that were finished are kept in results"), "{}", done.stderr);
    // And those begun meanwhile: one, or more where the processor is busy.
    let kept = fs::read_dir(place.path("results/s")).unwrap().count();
    assert!((1..50).contains(&kept), "{kept} runs");
}
