//! Tests of signal handling: finished runs are kept.
#![cfg(unix)]

use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{Place, Table};

/// Limit of each wait, far beyond the normal time, so that a hang ends the test.
const PATIENCE: Duration = Duration::from_secs(120);

/// Waits until the function returns a value.
#[track_caller]
fn wait_for<T>(what: &str, mut poll: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = poll() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "timeout: {what}");
        sleep(Duration::from_millis(5));
    }
}

fn lines(path: &Path) -> usize {
    std::fs::read_to_string(path).map_or(0, |text| text.matches('\n').count())
}

/// Sends the signal of Ctrl-C.
fn interrupt(child: &Child) {
    signal(child, "INT");
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("sh").args(["-c", &format!("kill -{name} {}", child.id())]).status().unwrap();
    assert!(sent.success());
}

/// Starts a batch in the background, with its standard error in the file `stderr`.
fn start(place: &Place, arguments: &[&str]) -> Child {
    let stderr = File::create(place.path("stderr")).unwrap();
    place.command(arguments).stdout(Stdio::null()).stderr(stderr).spawn().unwrap()
}

fn stderr_text(place: &Place) -> String {
    std::fs::read_to_string(place.path("stderr")).unwrap()
}

/// Bytes of the largest log, complete or not, in the folders of runs.
fn largest_log(folder: &Path) -> u64 {
    let inside = |path: &Path| std::fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path());
    let files = inside(folder).flat_map(|run| inside(&run).collect::<Vec<_>>());
    files.filter_map(|file| file.metadata().ok()).map(|file| file.len()).max().unwrap_or(0)
}

/// Schedulers send SIGTERM before SIGKILL.
#[test]
fn sigterm_is_handled_like_ctrl_c() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 5000\n");
    let mut child = start(&place, &["s.toml", "--set", "duration=20", "-j", "2"]);
    let rows = place.path("results/runs.jsonl");
    wait_for("the first row", || (lines(&rows) > 0).then_some(()));
    signal(&child, "TERM");
    let status = wait_for("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(143), "{}", stderr_text(&place));
    assert!(stderr_text(&place).contains("interrupted: no more runs are started"), "{}", stderr_text(&place));
    let outcomes = place.summary("results");
    assert!(outcomes.column("outcome").iter().all(|outcome| *outcome == "passed"), "running runs are finished");
    assert_eq!(outcomes.rows.len(), lines(&rows));

    // A second signal of either kind cancels. The exit code is that of the first.
    let long = ["s.toml", "--set", "duration=1e6", "--set", "log.rate=1", "-j", "2", "-o", "long"];
    let mut child = start(&place, &long);
    // A started run has a folder. Before that, the first signal would end the batch at once.
    let started = || std::fs::read_dir(place.path("long/s")).map_or(0, Iterator::count) > 0;
    wait_for("a start", || started().then_some(()));
    // Wait until the first signal is handled: two pending signals of one kind are merged.
    signal(&child, "TERM");
    wait_for("the first", || stderr_text(&place).contains("interrupted: ").then_some(()));
    signal(&child, "TERM");
    let status = wait_for("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(143), "{}", stderr_text(&place));
    assert!(stderr_text(&place).contains("interrupted again"), "{}", stderr_text(&place));
}

#[test]
fn the_first_signal_lets_running_runs_finish_and_keeps_all_rows() {
    let place = Place::new();
    // Thousands of long runs: the batch cannot end before the signal.
    place.block("s.toml", "[sweep]\nrepeat = 5000\n");
    let arguments = ["s.toml", "--set", "duration=20", "-j", "2", "--junit", "junit.xml"];
    let mut child = start(&place, &arguments);
    let rows = place.path("results/runs.jsonl");
    wait_for("the first row", || (lines(&rows) > 0).then_some(()));
    interrupt(&child);
    let status = wait_for("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(130), "{}", stderr_text(&place));
    assert!(stderr_text(&place).contains("interrupted: no more runs are started"), "{}", stderr_text(&place));
    let summary = place.summary("results");
    let finished = summary.rows.len();
    assert!((1..5000).contains(&finished), "{finished} rows");
    assert_eq!(lines(&rows), finished);
    assert!(summary.column("outcome").iter().all(|o| *o == "passed"), "running runs are finished");
    let junit = std::fs::read_to_string(place.path("junit.xml")).unwrap();
    let skipped = 5000 - finished;
    let counts = format!("tests=\"5000\" skipped=\"{skipped}\" failures=\"0\" errors=\"0\"");
    assert!(junit.contains(&counts), "{counts} in {}", &junit[..200]);
    assert_eq!(junit.matches("<skipped message=\"not started\"").count(), skipped);
    for key in summary.column("key") {
        let folder = place.path("results/s").join(key);
        assert!(folder.join("run.json").exists() && folder.join("log.mcap").exists(), "{key}");
    }
}

#[test]
fn the_second_signal_cancels_running_runs() {
    let place = Place::new();
    place.block("s.toml", "[log]\nrate = 1000\n[sweep]\ngrid = { duration = [0.01, 1e9] }\n");
    let mut child = start(&place, &["s.toml", "-j", "1", "--junit", "junit.xml"]);
    wait_for("the first row", || (lines(&place.path("results/runs.jsonl")) > 0).then_some(()));
    // The second run practically never ends by itself.
    let folder = place.path("results/s");
    // Its log grows by whole chunks: there is one once the run has advanced.
    wait_for("the second run", || (largest_log(&folder) > 200_000).then_some(()));
    interrupt(&child);
    wait_for("an answer", || stderr_text(&place).contains("again to cancel").then_some(()));
    assert!(child.try_wait().unwrap().is_none(), "the running run continues");
    interrupt(&child);
    let status = wait_for("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(130), "{}", stderr_text(&place));
    let summary: Table = place.summary("results");
    assert_eq!(summary.column("outcome"), ["passed", "cancelled"]);
    let junit = std::fs::read_to_string(place.path("junit.xml")).unwrap();
    assert!(junit.contains("<skipped message=\"interrupted\""), "{junit}");
    let reached = summary.numbers("duration_s")[1];
    assert!(reached > 0.0 && reached < 1e9, "{reached}");
    let log = folder.join(summary.column("key")[1]).join("log.mcap");
    let log = std::fs::read(log).unwrap();
    let read = mcap::Summary::read(&log).unwrap().expect("the log of a cancelled run is a complete file");
    let end = read.metadata_indexes.iter().find(|m| m.name == "end").expect("metadata `end`");
    let end = mcap::read::metadata(&log, end).unwrap();
    assert_eq!(end.metadata["complete"], "false", "the log is marked as incomplete");
}

#[test]
fn timing_stops_after_the_current_repetition() {
    let place = Place::new();
    place.block("s.toml", "[compare]\ntiming_repeats = 1000000\n");
    let mut child = start(&place, &["s.toml", "--set", "duration=0.5", "-j", "1"]);
    wait_for("timing", || stderr_text(&place).contains("timing: repetition 3 of").then_some(()));
    interrupt(&child);
    let status = wait_for("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(130), "{}", stderr_text(&place));
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["passed"]);
    assert!(summary.numbers("timing_cpu_min_s")[0] > 0.0, "finished repetitions are kept");
}

/// A session that waits for a line handles signals. The line comes from a pipe without a writer, or
/// from one that stays open.
#[test]
fn a_session_that_waits_for_a_line_handles_signals() {
    let place = Place::new();
    place.block("s.toml", "");
    place.shell("mkfifo pipe").exits(0);
    for (signalled, code) in [("INT", 130), ("TERM", 143)] {
        let arguments = ["console", "s.toml", "-c", "run 0.01", "-c", "save session begun.toml"];
        // First a pipe without a writer, then an open standard input without data.
        for more in [["--file", "pipe"].as_slice(), &[]] {
            let _ = std::fs::remove_file(place.path("begun.toml"));
            let stderr = File::create(place.path("stderr")).unwrap();
            let mut command =
                place.command(&[&arguments[..], &["--file", "-"][..(2 * usize::from(more.is_empty()))], more].concat());
            let mut child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(stderr).spawn().unwrap();
            wait_for("the first lines", || place.path("begun.toml").exists().then_some(()));
            signal(&child, signalled);
            let status = wait_for("the end", || child.try_wait().unwrap());
            assert_eq!(status.code(), Some(code), "{}", stderr_text(&place));
            assert!(stderr_text(&place).ends_with("interrupted\n"), "{}", stderr_text(&place));
        }
    }
}
