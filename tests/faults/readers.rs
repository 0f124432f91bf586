//! Programs that read results, or write their summary again, while a batch writes them.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use stiction::compare::{Limits, Results, compare};
use stiction::history::{Appended, Baseline, History, TrendRule, append};
use stiction::merge::{MergeError, Shards};
use stiction::replay::RecordedRun;
use stiction::results::{ResultsLock, RunsLog};

use crate::cli::Place;
use crate::support::same::files;

const IN_USE: &str = "another runner is using these results";

/// Friction coefficients of four runs.
const SWEEP: &str = "base = { linear_velocity = [1, 0, 0] }\n[sweep.grid]\n\"floor.friction\" = [0.4, 0.5, 0.6, 0.7]\n";

fn sweep() -> Place {
    let place = Place::new();
    place.block("s.toml", SWEEP);
    place
}

fn run(place: &Place, more: &[&str]) {
    place.runner(&[&["s.toml", "--set", "duration=0.1", "--no-log"], more].concat()).exits(0);
}

/// Names and bytes of all files.
fn content(folder: &Path) -> Vec<(String, Vec<u8>)> {
    files(folder).into_iter().map(|name| (name.clone(), fs::read(folder.join(name)).unwrap())).collect()
}

#[test]
fn results_of_a_running_batch_are_neither_compared_nor_reported() {
    let place = sweep();
    for output in ["a", "b"] {
        run(&place, &["-o", output]);
    }
    place.runner(&["compare", "--baseline", "h.parquet", "--append", "a", "--label", "first"]).exits(0);
    // As a batch in its middle: without its summary.
    for name in ["summary.csv", "summary.parquet", "report.html"] {
        fs::remove_file(place.path("b").join(name)).unwrap();
    }
    let batch = RunsLog::append(&place.path("b/runs.jsonl")).unwrap();
    let before = (content(&place.path("b")), fs::read(place.path("h.parquet")).unwrap());
    for arguments in [
        &["compare", "a", "b"][..],
        &["compare", "b", "a"],
        &["compare", "--baseline", "h.parquet", "--append", "b"],
        &["report", "b"],
    ] {
        let done = place.runner(arguments).exits(2);
        assert!(done.stderr.contains(IN_USE), "{arguments:?}: {}", done.stderr);
    }
    assert_eq!((content(&place.path("b")), fs::read(place.path("h.parquet")).unwrap()), before);
    // The lines so far, by their name.
    place.runner(&["compare", "a", "b/runs.jsonl"]).exits(0);
    drop(batch);
    place.runner(&["compare", "a", "b"]).exits(0);
    place.runner(&["report", "b"]).exits(0);
    assert_eq!(place.summary("b").rows.len(), 4);
}

#[test]
fn a_batch_does_not_begin_while_its_folder_is_read() {
    let place = sweep();
    run(&place, &["-o", "a"]);
    let before = content(&place.path("a"));
    let reader = ResultsLock::shared(&place.path("a")).unwrap();
    let done = place.runner(&["s.toml", "--set", "duration=0.2", "--no-log", "-o", "a"]).exits(2);
    assert!(done.stderr.contains(IN_USE), "{}", done.stderr);
    assert_eq!(content(&place.path("a")), before);
    // Other readers may read.
    place.runner(&["compare", "a", "a/summary.csv"]).exits(0);
    drop(reader);
    run(&place, &["-o", "a"]);
}

#[test]
fn shards_of_a_running_batch_are_not_merged() {
    let place = sweep();
    let shards = ["1", "2"].map(|i| format!("part-{i}"));
    for (i, output) in shards.iter().enumerate() {
        run(&place, &["--shard", &format!("{}/2", i + 1), "-o", output]);
    }
    let merge = ["merge", "part-1", "part-2", "-o", "merged"];
    let batch = RunsLog::append(&place.path("part-2/runs.jsonl")).unwrap();
    let done = place.runner(&merge).exits(2);
    assert!(done.stderr.contains(IN_USE) && done.stderr.contains("nothing was written"), "{}", done.stderr);
    assert!(!place.path("merged").exists());
    let done = place.runner(&[&merge[..], &["--partial"]].concat()).exits(0);
    assert!(done.stderr.contains("warning: part-2") && done.stderr.contains(IN_USE), "{}", done.stderr);
    drop(batch);
    // A result that is lost between check and copy, as on file systems without locks.
    let folders = [place.path("part-1"), place.path("part-2")];
    let opened = || {
        let shards = Shards::open(&folders).unwrap();
        let missing = shards.check().unwrap();
        assert!(missing.lines.is_empty(), "{missing:?}");
        (shards, missing)
    };
    let (shards, missing) = opened();
    let head = fs::read_to_string(folders[1].join("shard.jsonl")).unwrap();
    let other = head.replacen("\"plan\":\"", "\"plan\":\"0", 1);
    fs::write(folders[1].join("shard.jsonl"), other).unwrap();
    let error = shards.write(&place.path("changed"), &missing).unwrap_err();
    assert!(matches!(error, MergeError::Changed { .. }) && error.to_string().contains("part-2"), "{error}");
    drop(shards);
    fs::write(folders[1].join("shard.jsonl"), head).unwrap();
    let (shards, missing) = opened();
    let record = files(&folders[1]).into_iter().find(|name| name.ends_with("run.json")).unwrap();
    fs::remove_file(folders[1].join(record)).unwrap();
    let error = shards.write(&place.path("changed"), &missing).unwrap_err();
    assert!(matches!(error, MergeError::Changed { .. }) && error.to_string().contains("is gone"), "{error}");
    // Parts and output stay locked until the report is written.
    let folders = [place.path("part-1")];
    let shards = Shards::open(&folders).unwrap();
    let merged = shards.write(&place.path("one"), &shards.check().unwrap()).unwrap();
    assert!(RunsLog::append(&place.path("one/runs.jsonl")).is_err());
    assert!(RunsLog::append(&place.path("part-1/runs.jsonl")).is_err());
    drop((merged, shards));
    RunsLog::append(&place.path("one/runs.jsonl")).unwrap();
}

/// Rows, claims and time of a result are those of the moment at which it was opened.
#[test]
fn opened_results_stay_as_they_were() {
    let place = Place::new();
    let claim = "[[claim]]\nname = \"little\"\nchange = \"final_base_x\"\nat_most = 1e-5\n";
    place.block("s.toml", &format!("{SWEEP}{claim}"));
    run(&place, &["-o", "old", "--set", "gravity=[0, 0, -9.81]"]);
    let opened = |name: &str| Results::open(&place.path(name)).unwrap();
    for name in ["summary.csv", "summary.parquet"] {
        run(&place, &["-o", "new", "--set", "gravity=[0, 0, -8.0]"]);
        let written = fs::metadata(place.path("new").join(name)).unwrap().modified().unwrap();
        let mut results = opened(&format!("new/{name}"));
        // Another batch begins.
        fs::remove_file(place.path("new/claims.json")).unwrap();
        for name in ["summary.csv", "summary.parquet"] {
            fs::remove_file(place.path("new").join(name)).unwrap();
        }
        let changes = compare(&mut opened("old"), &mut results, &Limits::default()).unwrap();
        assert_eq!((changes.matched, changes.beyond.is_empty()), (4, false));
        let mut baseline = Baseline::open(&place.path("old")).unwrap();
        let compared = baseline.compare(&mut results, &Limits::default(), TrendRule { last: 10, level: 0.01 }).unwrap();
        let verdicts: Vec<_> = compared.claims.iter().map(|claim| claim.verdict.name()).collect();
        assert_eq!(verdicts, ["undecided"], "{name}: four pairs are too few");
        let history = place.path(&format!("{name}-h.parquet"));
        let appended = append(&history, &mut results, None, 10).unwrap();
        assert_eq!(appended, Appended::New { results: 1, rows: 4, removed: 0 });
        let since = written.duration_since(std::time::UNIX_EPOCH).unwrap();
        assert_eq!(History::read(&history).unwrap().entries[0].recorded_unix_s, since.as_secs() as i64);
    }
}

#[cfg(unix)]
#[test]
fn a_history_that_cannot_be_looked_at_is_not_replaced() {
    let place = sweep();
    run(&place, &["-o", "a"]);
    // A link to itself: the path leads nowhere, but not because there is nothing.
    let link = place.path("h.parquet");
    std::os::unix::fs::symlink(&link, &link).unwrap();
    let done = place.runner(&["compare", "--baseline", "h.parquet", "--append", "a"]).exits(2);
    assert!(done.stderr.contains("h.parquet"), "{}", done.stderr);
    assert!(link.is_symlink() && fs::read(&link).is_err());
}

/// The runs of an earlier batch are repeated while another one replaces them.
#[test]
fn a_replaced_record_is_known() {
    let place = sweep();
    run(&place, &["-o", "a"]);
    let record = files(&place.path("a")).into_iter().find(|name| name.ends_with("run.json")).unwrap();
    let path = place.path("a").join(record);
    let recorded = RecordedRun::read(&path).unwrap();
    assert!(!recorded.has_changed());
    let mut other = recorded.record.clone();
    other.timing.wall_s += 1.0;
    other.write(&path).unwrap();
    assert!(recorded.has_changed());
    recorded.record.write(&path).unwrap();
    assert!(!recorded.has_changed());
    fs::remove_file(&path).unwrap();
    assert!(recorded.has_changed());
}

/// A batch that removes damaged lines replaces the file that is the lock of its folder.
#[test]
fn the_lock_is_that_of_the_file_that_has_the_name() {
    let place = sweep();
    run(&place, &["-o", "a"]);
    let path = place.path("a/runs.jsonl");
    let whole = fs::read_to_string(&path).unwrap();
    for _ in 0..8 {
        let first = RunsLog::append(&path).unwrap();
        fs::write(&path, whole.replacen("\"seed\":", "\"seed\":1", 1)).unwrap();
        let begun = AtomicUsize::new(0);
        let begin = || _ = begun.fetch_add(1, Ordering::Relaxed);
        std::thread::scope(|scope| {
            let second = scope.spawn(|| {
                begin();
                RunsLog::append(&path).is_ok()
            });
            let reader = scope.spawn(|| {
                begin();
                ResultsLock::shared(&place.path("a")).is_ok()
            });
            while begun.load(Ordering::Relaxed) < 2 {
                std::thread::yield_now();
            }
            for _ in 0..20 {
                std::thread::yield_now();
            }
            first.logged().unwrap();
            assert!(!second.join().unwrap(), "both write");
            assert!(!reader.join().unwrap(), "the other one reads");
        });
        drop(first);
    }
}
