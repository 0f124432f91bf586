//! Ctrl-C: finished runs are kept.
#![cfg(unix)]

use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{Place, Table};

/// Far beyond what any step below needs, so that a hang ends the test.
const PATIENCE: Duration = Duration::from_secs(120);

/// Waits for something that will happen.
#[track_caller]
fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "{what} did not happen");
        sleep(Duration::from_millis(5));
    }
}

fn lines(path: &Path) -> usize {
    std::fs::read_to_string(path).map_or(0, |text| text.matches('\n').count())
}

/// As a terminal does on Ctrl-C.
fn interrupt(child: &Child) {
    signal(child, "INT");
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("sh").args(["-c", &format!("kill -{name} {}", child.id())]).status().unwrap();
    assert!(sent.success());
}

/// A batch in the background, its standard error in the file `stderr`.
fn start(place: &Place, arguments: &[&str]) -> Child {
    let stderr = File::create(place.path("stderr")).unwrap();
    place.command(arguments).stdout(Stdio::null()).stderr(stderr).spawn().unwrap()
}

fn said(place: &Place) -> String {
    std::fs::read_to_string(place.path("stderr")).unwrap()
}

/// As schedulers and servers do before they kill.
#[test]
fn to_be_terminated_is_to_be_interrupted() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 5000\n");
    let mut child = start(&place, &["s.toml", "--set", "duration=20", "-j", "2"]);
    let rows = place.path("results/runs.jsonl");
    until("the first row", || (lines(&rows) > 0).then_some(()));
    signal(&child, "TERM");
    let status = until("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(143), "{}", said(&place));
    assert!(said(&place).contains("interrupted: no more runs are started"), "{}", said(&place));
    let outcomes = place.summary("results");
    assert!(outcomes.column("outcome").iter().all(|outcome| *outcome == "passed"), "running ones are finished");
    assert_eq!(outcomes.rows.len(), lines(&rows));

    // A second one cancels, whichever it is; the code is of the first.
    let long = ["s.toml", "--set", "duration=1e6", "--set", "log.rate=1", "-j", "2", "-o", "long"];
    let mut child = start(&place, &long);
    // A run that has begun has its folder. Before that there would be nothing to wait for, and the end at once.
    let begun = || std::fs::read_dir(place.path("long/s")).map_or(0, Iterator::count) > 0;
    until("a start", || begun().then_some(()));
    // That it is told of the first before the second comes: two signals at once are one.
    signal(&child, "TERM");
    until("the first", || said(&place).contains("interrupted: ").then_some(()));
    signal(&child, "TERM");
    let status = until("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(143), "{}", said(&place));
    assert!(said(&place).contains("interrupted again"), "{}", said(&place));
}

#[test]
fn the_first_lets_running_runs_finish_and_keeps_the_rows() {
    let place = Place::new();
    // Thousands of runs of which each takes its time: no batch is over before the signal comes.
    place.block("s.toml", "[sweep]\nrepeat = 5000\n");
    let arguments = ["s.toml", "--set", "duration=20", "-j", "2", "--junit", "junit.xml"];
    let mut child = start(&place, &arguments);
    let rows = place.path("results/runs.jsonl");
    until("the first row", || (lines(&rows) > 0).then_some(()));
    interrupt(&child);
    let status = until("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(130), "{}", said(&place));
    assert!(said(&place).contains("interrupted: no more runs are started"), "{}", said(&place));
    let summary = place.summary("results");
    let finished = summary.rows.len();
    assert!((1..5000).contains(&finished), "{finished} rows");
    assert_eq!(lines(&rows), finished);
    assert!(summary.column("outcome").iter().all(|o| *o == "passed"), "what ran was finished");
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
fn the_second_cancels_what_is_running() {
    let place = Place::new();
    place.block("s.toml", "[log]\nrate = 1\n[sweep]\ngrid = { duration = [0.1, 1e9] }\n");
    let mut child = start(&place, &["s.toml", "-j", "1", "--junit", "junit.xml"]);
    until("the first row", || (lines(&place.path("results/runs.jsonl")) > 0).then_some(()));
    // The second run will not end by itself.
    let folder = place.path("results/s");
    until("the second run", || (std::fs::read_dir(&folder).unwrap().count() > 1).then_some(()));
    interrupt(&child);
    until("an answer", || said(&place).contains("again to cancel").then_some(()));
    assert!(child.try_wait().unwrap().is_none(), "the running run goes on");
    interrupt(&child);
    let status = until("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(130), "{}", said(&place));
    let summary: Table = place.summary("results");
    assert_eq!(summary.column("outcome"), ["passed", "cancelled"]);
    let junit = std::fs::read_to_string(place.path("junit.xml")).unwrap();
    assert!(junit.contains("<skipped message=\"interrupted\""), "{junit}");
    let reached = summary.numbers("duration_s")[1];
    assert!(reached > 0.0 && reached < 1e9, "{reached}");
    let log = folder.join(summary.column("key")[1]).join("log.mcap");
    let log = std::fs::read(log).unwrap();
    let read = mcap::Summary::read(&log).unwrap().expect("a cancelled run's log is whole as a file");
    let end = read.metadata_indexes.iter().find(|m| m.name == "end").expect("metadata `end`");
    let end = mcap::read::metadata(&log, end).unwrap();
    assert_eq!(end.metadata["complete"], "false", "and says that it is not all");
}

#[test]
fn timing_ends_with_the_repetition_at_hand() {
    let place = Place::new();
    place.block("s.toml", "[compare]\ntiming_repeats = 1000000\n");
    let mut child = start(&place, &["s.toml", "--set", "duration=0.5", "-j", "1"]);
    until("timing", || said(&place).contains("timing: repetition 3 of").then_some(()));
    interrupt(&child);
    let status = until("the end", || child.try_wait().unwrap());
    assert_eq!(status.code(), Some(130), "{}", said(&place));
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["passed"]);
    assert!(summary.numbers("timing_cpu_min_s")[0] > 0.0, "what was timed is kept");
}

/// Whoever waits for a line, from a pipe that nobody writes to or from one that stays open, can be asked to end.
#[test]
fn a_session_that_waits_for_a_line_ends() {
    let place = Place::new();
    place.block("s.toml", "");
    place.shell("mkfifo pipe").exits(0);
    for (signalled, code) in [("INT", 130), ("TERM", 143)] {
        let arguments = ["console", "s.toml", "-c", "run 0.01", "-c", "save session begun.toml"];
        // NoListener opens the pipe to write; and standard input that is open and says nothing.
        for more in [["--file", "pipe"].as_slice(), &[]] {
            let _ = std::fs::remove_file(place.path("begun.toml"));
            let stderr = File::create(place.path("stderr")).unwrap();
            let mut command =
                place.command(&[&arguments[..], &["--file", "-"][..(2 * usize::from(more.is_empty()))], more].concat());
            let mut child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(stderr).spawn().unwrap();
            until("the first lines", || place.path("begun.toml").exists().then_some(()));
            signal(&child, signalled);
            let status = until("the end", || child.try_wait().unwrap());
            assert_eq!(status.code(), Some(code), "{}", said(&place));
            assert!(said(&place).ends_with("interrupted\n"), "{}", said(&place));
        }
    }
}
