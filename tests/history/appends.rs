//! Appending: the same bits, once, whole, by several programs, and by other versions.

use std::fs::{self, File};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering};

use polars::prelude::{Column, NamedFrom, Series};
use polars_io::parquet::write::ParquetWriter;
use stiction::compare::Results;
use stiction::history::{History, HistoryErrorCause};

use super::{HEADER, Row, frame, table};
use crate::cli::Place;

const APPEND: [&str; 4] = ["compare", "--baseline", "h.parquet", "--append"];

fn append(place: &Place, more: &[&str]) -> crate::cli::Done {
    place.runner(&[&APPEND, more].concat())
}

#[test]
fn all_values_of_real_runs_keep_their_bits() {
    let place = Place::new();
    place.block("s.toml", "base = { linear_velocity = [1, 0, 0] }\n[sweep.grid]\n\"floor.friction\" = [0.4, 0.8]\n");
    place.runner(&["s.toml", "--set", "duration=0.5", "--no-log", "-o", "a"]).exits(0);
    append(&place, &["--label", "v1", "a"]).exits(0);
    let (history, summary) = (frame(&place.path("h.parquet")), place.summary("a"));
    assert_eq!(history.height(), 2);
    let text = |name: &str, row: usize| history.column(name).unwrap().str().unwrap().get(row).map(str::to_owned);
    let mut measured = 0;
    for row in 0..2 {
        for name in ["scenario", "key", "outcome", "method", "integrator", "seed"] {
            assert_eq!(text(name, row).as_deref(), Some(summary.column(name)[row]), "{name}");
        }
        assert_eq!(text("label", row).as_deref(), Some("v1"));
        assert_eq!(text("program", row).as_deref(), Some(stiction::results::PROGRAM));
        let friction = summary.column("floor.friction")[row];
        assert_eq!(text("parameters", row).unwrap(), format!("{{\"floor.friction\":\"{friction}\"}}"));
        for name in stiction::results::NUMERIC_COLUMNS {
            let cell = summary.column(name)[row];
            let kept = history.column(name).ok().and_then(|column| column.f64().unwrap().get(row));
            let bits = |x: f64| x.to_bits();
            assert_eq!(kept.map(bits), cell.parse().ok().map(bits), "{name}: {cell}");
            measured += usize::from(kept.is_some());
        }
    }
    assert!(measured > 60, "{measured}");
    // Compared without tolerances: another result with the same values, but for a time.
    let line = fs::read_to_string(place.path("a/summary.csv")).unwrap();
    let time = summary.column("wall_s")[0];
    place.write("same.csv", line.replacen(time, "1234.5", 1));
    let compare = ["compare", "--baseline", "h.parquet", "same.csv", "--absolute", "0", "--relative", "0"];
    let done = place.runner(&compare).exits(0);
    assert!(done.stdout.contains("2 runs compared: within the tolerances"), "{}", done.stdout);
    let last = fs::metadata(place.path("a/summary.csv")).unwrap().modified().unwrap();
    let last = last.duration_since(std::time::UNIX_EPOCH).unwrap().as_secs() as i64;
    assert_eq!(history.column("recorded_unix_s").unwrap().i64().unwrap().get(0), Some(last));
}

#[test]
fn a_result_is_appended_once_in_any_format_and_order() {
    let place = Place::new();
    place.block("s.toml", "base = { linear_velocity = [1, 0, 0] }\n[sweep]\nrepeat = 3\n");
    place.runner(&["s.toml", "--set", "duration=0.1", "--no-log", "-o", "a"]).exits(0);
    append(&place, &["--label", "v1", "a"]).exits(0);
    let whole = fs::read(place.path("h.parquet")).unwrap();
    let text = fs::read_to_string(place.path("a/summary.csv")).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    lines[1..].reverse();
    place.write("reversed.csv", lines.join("\n") + "\n");
    for again in ["a", "a/summary.parquet", "a/runs.jsonl", "reversed.csv"] {
        let done = append(&place, &["--label", "v2", again]).exits(0);
        assert!(done.stdout.contains("not appended: the history has this result as v1"), "{again}: {}", done.stdout);
        assert!(done.stdout.contains("not compared: the history has no other results"), "{}", done.stdout);
    }
    assert_eq!(fs::read(place.path("h.parquet")).unwrap(), whole);
}

#[test]
fn versions_with_other_columns_share_a_history() {
    let place = Place::new();
    place.write("old.csv", "scenario,key,outcome,method,seed,mu,steps\ns,k0,passed,exact,1,0.5,7\n");
    table(&place, "new.csv", "n", &[Row("0.5", 8, 0.25, 1.0), Row("0.6", 9, 0.5, 1.0)]);
    append(&place, &["old.csv"]).exits(0);
    append(&place, &["new.csv"]).exits(1);
    let first = frame(&place.path("h.parquet"));
    let numbers = |frame: &polars::prelude::DataFrame, name: &str| -> Vec<Option<f64>> {
        let column = frame.column(name).unwrap().f64().unwrap().clone();
        (0..frame.height()).map(|row| column.get(row)).collect()
    };
    assert_eq!(numbers(&first, "final_base_x"), [None, Some(0.25), Some(0.5)]);
    assert_eq!(numbers(&first, "steps"), [Some(7.0), Some(8.0), Some(9.0)]);
    assert!(first.column("max_penetration_m").is_err(), "a column without values");
    // The old version does not know the column, and keeps it.
    place.write("old.csv", "scenario,key,outcome,method,seed,mu,steps\ns,k1,passed,exact,1,0.5,8\n");
    append(&place, &["old.csv"]).exits(1);
    assert_eq!(numbers(&frame(&place.path("h.parquet")), "final_base_x"), [None, Some(0.25), Some(0.5), None]);
    // As does this one with a column of another type that a later version added.
    let mut later = frame(&place.path("h.parquet"));
    later.with_column(Column::from(Series::new("machine".into(), vec!["x"; 4]))).unwrap();
    ParquetWriter::new(File::create(place.path("h.parquet")).unwrap()).finish(&mut later).unwrap();
    table(&place, "new.csv", "n", &[Row("0.5", 8, 0.26, 1.0)]);
    append(&place, &["new.csv"]).exits(1);
    let machine = frame(&place.path("h.parquet")).column("machine").unwrap().str().unwrap().clone();
    assert_eq!((machine.get(0), machine.get(4)), (Some("x"), None));
    // A later format is refused.
    let mut later = frame(&place.path("h.parquet"));
    later.with_column(Column::from(Series::new("schema".into(), vec![2_u32; 5]))).unwrap();
    ParquetWriter::new(File::create(place.path("h.parquet")).unwrap()).finish(&mut later).unwrap();
    let done = append(&place, &["new.csv"]).exits(2);
    let expected = "h.parquet: row 1: the history has format version 2, this program reads version 1";
    assert!(done.stderr.contains(expected), "{}", done.stderr);
}

#[test]
fn the_oldest_results_leave_a_full_history() {
    let place = Place::new();
    for (i, results) in [1, 2, 3, 3].into_iter().enumerate() {
        table(&place, "r.csv", "v", &[Row("0.5", i as u64, 0.0, 1.0), Row("0.6", 0, 0.0, 1.0)]);
        let done = append(&place, &["--keep", "3", "--label", &format!("v{i}"), "r.csv"]);
        let expected = format!("the history has {results} result");
        assert!(done.stdout.contains(&expected), "{}", done.stdout);
    }
    let history = History::read(&place.path("h.parquet")).unwrap();
    let labels: Vec<String> = history.entries.iter().map(stiction::history::Entry::title).collect();
    assert_eq!(labels, ["v1", "v2", "v3"]);
    assert!(history.entries.iter().all(|entry| entry.runs() == 2));
}

#[test]
fn other_files_are_not_replaced_and_failed_appends_change_nothing() {
    let place = Place::new();
    table(&place, "r.csv", "v", &[Row("0.5", 1, 0.0, 1.0)]);
    place.block("s.toml", "").write("damaged.parquet", "PAR1 damaged").write("text.parquet", "text").write("x.csv", "");
    place.runner(&["s.toml", "--set", "duration=0.01", "--no-log", "-o", "a"]).exits(0);
    place.write("bad.csv", format!("{HEADER}\ns,k,passed,,exact,dopri5,1,0.5,1.0,1.0,many,0.5,\n"));
    for (history, results, text) in [
        ("a/summary.parquet", "r.csv", "not a history: it has no column `schema`"),
        ("damaged.parquet", "r.csv", "damaged.parquet: "),
        ("text.parquet", "r.csv", "text.parquet: "),
        ("x.csv", "r.csv", "the name of a history ends with .parquet"),
        ("new.parquet", "bad.csv", "bad.csv: row 1: column `steps` has the value `many`, expected a number"),
    ] {
        let before = fs::read(place.path(history)).ok();
        let done = place.runner(&["compare", "--baseline", history, "--append", results]).exits(2);
        assert!(done.stderr.contains(text), "{history}: {}", done.stderr);
        assert_eq!(fs::read(place.path(history)).ok(), before, "{history}");
    }
    for (arguments, text) in [
        (&["compare", "--baseline", "none.parquet", "r.csv"][..], "none.parquet: No such file"),
        (&["compare", "--append", "r.csv"], "--baseline"),
        (&["compare", "--baseline", "r.csv", "--label", "x", "r.csv"], "--append"),
        (&["compare", "--baseline", "r.csv", "--last", "0", "r.csv"], "0 is not in 1..=200"),
        (
            &["compare", "--baseline", "r.csv", "--trend", "1", "r.csv"],
            "expected a number greater than 0 and less than 1",
        ),
        (&["compare", "r.csv"], "two results are required"),
        (&["compare", "r.csv", "r.csv", "r.csv"], "two results are required"),
        (&["compare", "--baseline", "r.csv"], "required"),
    ] {
        let done = place.runner(arguments).exits(2);
        assert!(done.stderr.contains(text), "{arguments:?}: {}", done.stderr);
    }
    assert!(!place.path("none.parquet").exists() && !place.path("new.parquet").exists());
    let error = History::read(&place.path("none.parquet")).unwrap_err();
    assert!(matches!(error.cause, HistoryErrorCause::Io(_)), "{error}");
}

/// Programs wait for each other: no result is lost.
#[test]
fn programs_that_append_at_once_lose_no_result() {
    const PROGRAMS: usize = 8;
    let place = Place::new();
    let mut running = Vec::new();
    for i in 0..PROGRAMS {
        let name = format!("r{i}.csv");
        table(&place, &name, "v", &[Row("0.5", i as u64, 0.0, 1.0), Row("0.6", i as u64, 0.5, 1.0)]);
    }
    for i in 0..PROGRAMS {
        let (label, name) = (format!("v{i}"), format!("r{i}.csv"));
        let mut command = place.command(&[&APPEND[..], &["--label", &label, &name]].concat());
        running.push(command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap());
    }
    for child in running {
        let done = child.wait_with_output().unwrap();
        assert!(matches!(done.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&done.stderr));
    }
    let history = History::read(&place.path("h.parquet")).unwrap();
    let mut labels: Vec<String> = history.entries.iter().map(stiction::history::Entry::title).collect();
    labels.sort();
    assert_eq!(labels, (0..PROGRAMS).map(|i| format!("v{i}")).collect::<Vec<_>>());
    assert!(history.entries.iter().all(|entry| entry.runs() == 2));
}

/// A history and a table are replaced while they are read, by others with another number of rows.
#[test]
fn readers_find_the_old_file_or_the_new_one() {
    const READS: usize = 300;
    let place = Place::new();
    for (i, rows) in [1, 400].into_iter().enumerate() {
        let values: Vec<String> = (0..rows).map(|i| format!("{i}")).collect();
        let rows: Vec<Row> = values.iter().map(|mu| Row(mu, 1, 0.0, 1.0)).collect();
        table(&place, "r.csv", "v", &rows);
        let history = format!("h{i}.parquet");
        place.runner(&["compare", "--baseline", &history, "--append", "r.csv"]).exits(0);
        let path = place.path(&format!("s{i}.parquet"));
        let mut runs = frame(&place.path(&history)).drop("result").unwrap();
        ParquetWriter::new(File::create(path).unwrap()).finish(&mut runs).unwrap();
    }
    let files = |name: &str| [0, 1].map(|i| fs::read(place.path(&format!("{name}{i}.parquet"))).unwrap());
    let kinds = ["h", "s"].map(|name| (place.path(&format!("{name}.parquet")), files(name)));
    let put = |turn: usize| {
        for (path, files) in &kinds {
            let next = path.with_extension("next");
            fs::write(&next, &files[turn % 2]).unwrap();
            fs::rename(next, path).unwrap();
        }
    };
    // One that other programs write in place, as the library for tables would read it from the disk.
    let in_place = place.path("in-place.parquet");
    put(0);
    let is_done = AtomicBool::new(false);
    let mut found = [[0; 2]; 2];
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for turn in (1..).take_while(|_| !is_done.load(Ordering::Relaxed)) {
                put(turn);
                fs::write(&in_place, &kinds[1].1[turn % 2]).unwrap();
            }
        });
        let read = catch_unwind(AssertUnwindSafe(|| {
            for _ in 0..READS {
                let rows = History::read(&kinds[0].0).unwrap().entries[0].runs();
                found[0][usize::from(rows == 400)] += 1;
                let rows = Results::open(&kinds[1].0).unwrap().len();
                found[1][usize::from(rows == 400)] += 1;
                // Half of it may be there.
                assert!(Results::open(&in_place).map_or(true, |results| [1, 400].contains(&results.len())));
            }
        }));
        is_done.store(true, Ordering::Relaxed);
        read.unwrap();
    });
    assert!(found.as_flattened().iter().all(|count| *count > 0), "{found:?}");
}

/// The program is killed once its unfinished file appears, at any moment of the write.
#[test]
fn killed_appends_leave_a_whole_history() {
    const KILLS: u64 = 10;
    let place = Place::new();
    fs::create_dir(place.path("h")).unwrap();
    let texts: Vec<String> = (0..3000).map(|i| format!("{i}")).collect();
    let write = |version: u64| {
        let rows: Vec<Row> = texts.iter().map(|mu| Row(mu, version, 0.1, version as f64)).collect();
        table(&place, "r.csv", "v", &rows);
    };
    write(0);
    let arguments = ["compare", "--baseline", "h/history.parquet", "--append", "r.csv"];
    place.runner(&arguments).exits(0);
    let unfinished = || {
        let entries = fs::read_dir(place.path("h")).unwrap();
        entries.filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().ends_with(".partial")).count()
    };
    let (mut killed, mut results) = (0, 1);
    for version in 1..=KILLS {
        write(version);
        let mut child = place.command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let ended = loop {
            if unfinished() > 0 {
                break false;
            }
            if child.try_wait().unwrap().is_some() {
                break true;
            }
            std::thread::yield_now();
        };
        child.kill().unwrap();
        child.wait().unwrap();
        killed += u64::from(!ended);
        let history = History::read(&place.path("h/history.parquet")).unwrap();
        assert!([results, results + 1].contains(&history.entries.len()), "{version}");
        assert!(history.entries.iter().all(|entry| entry.runs() == texts.len()));
        results = history.entries.len();
    }
    assert!(killed > 0, "no program was killed while it wrote");
    // The next one removes what they left.
    write(KILLS + 1);
    place.runner(&arguments).exits(1);
    assert_eq!(unfinished(), 0);
    assert_eq!(History::read(&place.path("h/history.parquet")).unwrap().entries.len(), results + 1);
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_old_history() {
    let place = Place::new();
    table(&place, "r.csv", "v", &[Row("0.5", 1, 0.0, 1.0)]);
    append(&place, &["r.csv"]).exits(0);
    let before = fs::read(place.path("h.parquet")).unwrap();
    table(&place, "r.csv", "w", &[Row("0.5", 1, 0.0, 2.0)]);
    // Blocks of 512 or 1024 bytes; the file has some 8 kB.
    let done = place.shell("ulimit -f 2; exec \"$0\" compare --baseline h.parquet --append r.csv").exits(3);
    assert!(done.stderr.contains("h.parquet"), "{}", done.stderr);
    assert!(done.stdout.contains("1 runs compared"), "the comparison is printed: {}", done.stdout);
    assert_eq!(fs::read(place.path("h.parquet")).unwrap(), before);
}
