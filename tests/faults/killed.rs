//! `kill -9` at any moment.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{ARGUMENTS, ENDS, batch, everything_is_whole};
use crate::cli::{Done, Place};
use crate::same::{assert_same, files};

/// Moments at which a batch is killed.
const KILLS: usize = 50;

/// Records below a folder, those of references included.
fn records(results: &Path) -> usize {
    if results.exists() { files(results).iter().filter(|f| f.ends_with("run.json")).count() } else { 0 }
}

/// Starts the batch and kills it some time later, unless it has ended by then. What holds afterwards holds at every
/// moment, so it does not matter which was met.
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
    everything_is_whole(&results);
    // Every run whose end was told is kept: none but those that were running are lost.
    let told = done.stderr.lines().filter(|line| line.starts_with('[')).count();
    assert!(records(&results) >= told, "{} records\n{}", records(&results), done.stderr);
}

#[test]
fn a_batch_that_is_killed_at_any_moment_is_completed_to_the_same_bits() {
    let place = batch();
    let begin = Instant::now();
    place.runner(&[&ARGUMENTS[..], &["-o", "whole"]].concat()).exits(ENDS);
    let whole = begin.elapsed();
    let all = records(&place.path("whole"));
    assert_eq!(all, 16 + 4);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut met = Vec::new();
    let mut batches = 0;
    while met.len() < KILLS {
        let output = format!("killed-{batches}");
        batches += 1;
        // A few times in a row: what resumes may be killed as well.
        for _ in 0..random.random_range(1..=3) {
            start_and_kill(&place, &output, whole.mul_f64(random.random_range(0.0..1.1)));
            met.push(records(&place.path(&output)));
        }
        let done = place.runner(&[&ARGUMENTS[..], &["--resume", "-o", &output]].concat()).exits(ENDS);
        assert!(done.stderr.contains("resumed: "), "{}", done.stderr);
        assert_same(&place.path("whole"), &place.path(&output));
        fs::remove_dir_all(place.path(&output)).unwrap();
    }
    // Were all of them before the first run or after the last, nothing would have been shown.
    let between = met.iter().filter(|n| (1..all).contains(n)).count();
    assert!(between > 0, "{met:?}");
}
