//! Tests of a full disk: a clear error, and finished runs are kept.
#![cfg(unix)]

use std::fs;
use std::io::ErrorKind;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use stiction::batch::{Batch, Job, Options, Progress, RunEnd, RunOutputs, prepare, simulate};
use stiction::files::RecordError;
use stiction::report::batch_page;

use super::{ARGUMENTS, EXIT_CODE, assert_all_files_complete, batch};
use crate::cli::{Done, Place};
use crate::support::same::assert_same;

/// Runs the program with a limit on the size of files. The limit is in blocks of the shell, of 512
/// or 1024 bytes. The system sends SIGXFSZ at a write beyond the limit, which then fails.
fn run_with_file_size_limit(place: &Place, blocks: u32, arguments: &[&str]) -> Done {
    place.shell(&format!("ulimit -f {blocks}; exec \"$0\" {}", arguments.join(" ")))
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

/// Runs a shell command in a name space of its own, with a file system of `size` at `small`. None
/// where users may not have one.
fn run_on_small_disk(place: &Place, size: &str, line: &str) -> Option<Done> {
    fs::create_dir_all(place.path("small")).unwrap();
    let mount = format!("mount -t tmpfs -o size={size} tmpfs small");
    if place.shell(&format!("unshare -rm sh -c '{mount}'")).code != Some(0) {
        eprintln!("skipped: no file systems in name spaces of users here");
        return None;
    }
    Some(place.shell(&format!("unshare -rm sh -c '{mount}; {line}' \"$0\"")))
}

#[test]
fn a_full_file_system_ends_the_batch_and_resume_completes_it() {
    let place = Place::new();
    // A log takes some 300 kB.
    place.block("s.toml", "[log]\nrate = 1000\n[sweep]\nrepeat = 40\n");
    place.runner(&["s.toml", "-o", "whole"]).exits(0);
    // One run at a time: of two, one could find no room in `runs.jsonl`, which ends the batch too.
    // Copied before the file system vanishes; resumed on one that has room.
    let line = "\"$0\" s.toml -j 1 -o small/results; code=$?; cp -r small/results kept; exit $code";
    let Some(done) = run_on_small_disk(&place, "2m", line) else { return };
    let done = done.exits(3);
    assert!(done.stderr.contains("log.mcap: No space left on device"), "{}", done.stderr);
    assert!(done.stderr.contains("no more runs start, because the disk or a quota is full"), "{}", done.stderr);
    assert!(done.stderr.contains("with --resume"), "{}", done.stderr);
    let ran = fs::read_dir(place.path("kept/s")).unwrap().count();
    let list = fs::read_to_string(place.path("kept/runs.jsonl")).unwrap();
    let (errors, passed): (Vec<&str>, Vec<&str>) =
        list.split_inclusive('\n').partition(|line| line.contains("\"outcome\":\"error\""));
    let failed = errors.len();
    // A re-run adds a line.
    fs::write(place.path("kept/runs.jsonl"), passed.concat()).unwrap();
    assert!((1..40).contains(&ran) && failed == 1, "{ran} runs, {failed} errors");
    place.runner(&["s.toml", "-o", "kept", "--resume"]).exits(0);
    assert_same(&place.path("whole"), &place.path("kept"));
}

#[test]
fn a_run_on_a_full_disk_is_the_last_to_start() {
    let place = Place::new();
    place.write("s.toml", "duration = 0.01\nrobot = { model = \"block/block.toml\" }\n[sweep]\nrepeat = 20\n");
    let (plan, _) = prepare(&[place.path("s.toml")], &[], 100).unwrap_or_else(|_| panic!("refused"));
    let output = place.path("results");
    let options = Options { jobs: 1, output: output.clone(), ..Options::default() };
    let ran = AtomicUsize::new(0);
    let body = |job: &Job, outputs: &RunOutputs, cancel: &AtomicBool| {
        if ran.fetch_add(1, Ordering::Relaxed) == 4 {
            let source = ErrorKind::QuotaExceeded.into();
            return RunEnd::of_unwritten(&RecordError::Io { path: "log.mcap".into(), source });
        }
        simulate(job, outputs, cancel)
    };
    let error = Batch::new(plan, options, batch_page).unwrap().run(Progress::Silent, &body).unwrap_err().to_string();
    assert!(error.contains("log.mcap") && error.contains("no more runs start"), "{error}");
    assert_eq!(ran.load(Ordering::Relaxed), 5);
    assert_eq!(fs::read_dir(output.join("s")).unwrap().count(), 5);
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
