//! Test of `kill -9` at random moments.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{ARGUMENTS, EXIT_CODE, assert_all_files_complete, batch};
use crate::cli::{Done, Place};
use crate::support::same::{assert_same, files};

/// Number of kills.
const KILLS: usize = 50;

/// Number of records below a folder, including those of references.
fn records(results: &Path) -> usize {
    if results.exists() { files(results).iter().filter(|f| f.ends_with("run.json")).count() } else { 0 }
}

/// Starts the batch and kills it after a delay, unless it has ended by then. The assertions hold at
/// every moment, so the exact time of the kill does not matter.
fn start_and_kill(place: &Place, output: &str, after: Duration) {
    let arguments = [&ARGUMENTS[..], &["--resume", "-o", output]].concat();
    let mut child = place.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(after);
    child.kill().unwrap();
    let done = Done::from(child.wait_with_output().unwrap());
    let results = place.path(output);
    if !results.exists() {
        return;
    }
    assert_all_files_complete(&results);
    // Every run reported as finished has a record: only running runs are lost.
    let reported = done.stderr.lines().filter(|line| line.starts_with('[')).count();
    assert!(records(&results) >= reported, "{} records\n{}", records(&results), done.stderr);
}

#[test]
fn resume_completes_a_killed_batch_to_the_same_bits() {
    let place = batch();
    let begin = Instant::now();
    place.runner(&[&ARGUMENTS[..], &["-o", "whole"]].concat()).exits(EXIT_CODE);
    let whole = begin.elapsed();
    let all = records(&place.path("whole"));
    assert_eq!(all, 16 + 4);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut finished = Vec::new();
    let mut batches = 0;
    while finished.len() < KILLS {
        let output = format!("killed-{batches}");
        batches += 1;
        // Several times in a row, because a resumed batch may be killed as well.
        for _ in 0..random.random_range(1..=3) {
            start_and_kill(&place, &output, whole.mul_f64(random.random_range(0.0..1.1)));
            finished.push(records(&place.path(&output)));
        }
        let done = place.runner(&[&ARGUMENTS[..], &["--resume", "-o", &output]].concat()).exits(EXIT_CODE);
        assert!(done.stderr.contains("resumed: "), "{}", done.stderr);
        assert_same(&place.path("whole"), &place.path(&output));
        fs::remove_dir_all(place.path(&output)).unwrap();
    }
    // Kills only before the first run or after the last would test nothing.
    let between = finished.iter().filter(|n| (1..all).contains(n)).count();
    assert!(between > 0, "{finished:?}");
}
