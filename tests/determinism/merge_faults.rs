//! Merging damaged shards, and inputs that are not shards.

use std::fs;
use std::path::PathBuf;

use super::run;
use crate::cli::{Done, Place};
use crate::support::same::{assert_same, files};

const FILES: [&str; 3] = ["thrown.toml", "compared.toml", "silent.toml"];

/// Two shards in `a` and `b`, the second with these options: runs with logs, with references, and
/// runs with logging disabled.
fn shards(more: &[&str]) -> Place {
    let place = super::scenarios();
    place.block("silent.toml", "[log]\nrate = 0\n[sweep]\nrepeat = 6\n");
    run(&place, &FILES, &["--shard", "1/2", "-o", "a"]);
    run(&place, &FILES, &[&["--shard", "2/2", "-o", "b"], more].concat());
    place
}

fn merge(place: &Place, more: &[&str]) -> Done {
    place.runner(&[&["merge", "a", "b", "-o", "merged"], more].concat())
}

fn first(place: &Place, of: &str, name: &str) -> PathBuf {
    let below = files(&place.path(of)).into_iter().find(|f| f.contains("thrown") && f.ends_with(name));
    place.path(of).join(below.expect("a run with a log"))
}

#[test]
fn a_changed_log_is_reported() {
    let place = shards(&[]);
    run(&place, &FILES, &["-o", "whole"]);
    let log = first(&place, "b", "log.mcap");
    let key = log.parent().unwrap().file_name().unwrap().to_str().unwrap().to_owned();
    let bytes = fs::read(&log).unwrap();
    let mut hole = bytes.clone();
    hole[bytes.len() / 2] ^= 1;
    let rows = place.summary("whole").rows.len();
    for (now, why) in [
        (None, "its log is missing"),
        (Some(&bytes[..bytes.len() - 100]), "its log is shorter than the recorded one"),
        (Some(&hole[..]), "its log is not the recorded one"),
    ] {
        match now {
            Some(now) => fs::write(&log, now).unwrap(),
            None => fs::remove_file(&log).unwrap(),
        }
        let done = merge(&place, &[]).exits(2);
        let expected = format!(
            "error: b (shard 2/2) has no result of 1 of its runs: thrown {key} ({why}); run it again with --resume"
        );
        assert!(done.stderr.contains(&expected), "{}", done.stderr);
        assert!(done.stderr.contains("nothing was written") && !place.path("merged").exists(), "{}", done.stderr);
        let done = merge(&place, &["--partial"]);
        assert!(done.stderr.contains(&format!("thrown {key} ({why})")), "{}", done.stderr);
        let table = place.summary("merged");
        assert!(table.rows.len() == rows - 1 && !table.column("key").contains(&key.as_str()), "{why}");
        assert!(!place.path("merged/thrown").join(&key).exists());
        fs::remove_dir_all(place.path("merged")).unwrap();
    }
    run(&place, &FILES, &["--shard", "2/2", "-o", "b", "--resume"]);
    assert!(matches!(merge(&place, &[]).code, Some(0 | 1)));
    assert_same(&place.path("whole"), &place.path("merged"));
}

#[test]
fn an_incomplete_record_is_reported_and_left_out() {
    let place = shards(&[]);
    let record = first(&place, "a", "run.json");
    fs::write(&record, "{").unwrap();
    let done = merge(&place, &[]).exits(2);
    assert!(done.stderr.contains("(its record is incomplete); run it again with --resume"), "{}", done.stderr);
    assert!(!place.path("merged").exists());
    // The complete record of another run.
    let others = files(&place.path("a")).into_iter().filter(|f| f.contains("thrown") && f.ends_with("run.json"));
    let other = others.map(|f| place.path("a").join(f)).find(|path| *path != record).expect("two runs");
    fs::copy(&other, &record).unwrap();
    let done = merge(&place, &[]).exits(2);
    assert!(done.stderr.contains("(its record belongs to another run); run it again"), "{}", done.stderr);
    assert!(!place.path("merged").exists());
    merge(&place, &["--partial"]).exits(0);
    let reference = files(&place.path("b")).into_iter().find(|f| f.contains("references/")).unwrap();
    fs::remove_file(place.path("b").join(&reference)).unwrap();
    let other = place.path("a").join(&reference);
    if other.exists() {
        fs::remove_file(&other).unwrap();
    }
    let done = merge(&place, &[]).exits(2);
    assert!(done.stderr.contains("has no complete record of reference"), "{}", done.stderr);
    merge(&place, &["--partial"]).exits(0);
}

#[test]
fn shards_with_and_without_logs_do_not_merge() {
    let place = shards(&["--no-log"]);
    let done = merge(&place, &[]).exits(2);
    assert!(done.stderr.contains("some runs have no log (--no-log) and others have one"), "{}", done.stderr);
    assert!(done.stderr.contains(" of b (shard 2/2), such as ") && !done.stderr.contains("of a ("), "{}", done.stderr);
    assert!(!place.path("merged").exists());
    let done = merge(&place, &["--partial"]).exits(0);
    assert!(done.stderr.contains("warning: some runs have no log"), "{}", done.stderr);
    assert_eq!(place.summary("merged").rows.len(), 8 + 6 + 6);
    // All runs without logs are one batch. Runs with `log.rate = 0` may be next to runs with logs.
    run(&place, &FILES, &["--shard", "1/2", "-o", "a", "--no-log"]);
    merge(&place, &[]).exits(0);
    run(&place, &FILES, &["--shard", "1/2", "-o", "a"]);
    run(&place, &FILES, &["--shard", "2/2", "-o", "b"]);
    merge(&place, &[]).exits(0);
}

#[test]
fn an_input_that_is_no_results_folder_is_reported_with_help() {
    let place = shards(&[]);
    for (given, what) in [("a/summary.csv", "a file, not a folder"), ("nowhere", "no such folder")] {
        let done = place.runner(&["merge", "a", given, "-o", "merged"]).exits(2);
        let expected =
            format!("error: {given}: {what}\nhelp: name the folders of results of all shards, as `runner run");
        assert!(done.stderr.contains(&expected), "{}", done.stderr);
    }
    assert!(!place.path("merged").exists());
}

#[test]
fn a_job_array_of_one_task_gives_a_warning() {
    let place = super::scenarios();
    let warned = |shard: &str, count: &str, name: &str| {
        let mut command = place.command(&["list", "thrown.toml", "--shard", shard]);
        command.env_remove("JOB_COMPLETION_INDEX").env_remove("SLURM_ARRAY_TASK_ID");
        let variables = [(name, "3"), ("SLURM_ARRAY_TASK_MIN", "3"), ("SLURM_ARRAY_TASK_COUNT", count)];
        let done = Done::from(command.envs(variables).output().unwrap()).exits(0);
        done.stderr.matches("warning: the job array has one task, which therefore has all runs").count()
    };
    assert_eq!(warned("env", "1", "SLURM_ARRAY_TASK_ID"), 1);
    assert_eq!(warned("env", "2", "SLURM_ARRAY_TASK_ID"), 0);
    assert_eq!(warned("1/1", "1", "SLURM_ARRAY_TASK_ID"), 0, "it was typed");
}

/// A log that is not a regular file is neither read nor waited for.
#[cfg(unix)]
#[test]
fn a_log_that_is_no_file_is_reported() {
    let place = shards(&[]);
    let log = first(&place, "b", "log.mcap");
    fs::remove_file(&log).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&log).status().unwrap().success());
    let done = merge(&place, &[]).exits(2);
    assert!(done.stderr.contains("(its log is not a file); run it again with --resume"), "{}", done.stderr);
    fs::remove_file(&log).unwrap();
    fs::create_dir(&log).unwrap();
    let done = merge(&place, &[]).exits(2);
    assert!(done.stderr.contains("(its log is not a file)"), "{}", done.stderr);
    assert!(!place.path("merged").exists());
}

/// An input is never overwritten, by whatever path it is named.
#[test]
fn output_and_input_folders_must_not_overlap() {
    let place = shards(&[]);
    let before = [files(&place.path("a")), files(&place.path("b"))];
    let to = |output: &str| place.runner(&["merge", "a", "b", "-o", output]).exits(2).stderr;
    let nested = to("b/merged");
    assert!(
        nested.contains("b/merged: the output folder is inside the input b\nhelp: name a folder outside"),
        "{nested}"
    );
    assert!(to("./nowhere/../b/deep/er").contains("is inside the input b"), "a name with dots");
    assert!(to("b/../a").contains("inside the input"));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(place.path("b"), place.path("link")).unwrap();
        assert!(to("link/merged").contains("link/merged: the output folder is inside the input b"));
    }
    // `thrown` is a scenario: its results would be written into that input.
    fs::rename(place.path("b"), place.path("thrown")).unwrap();
    let over = place.runner(&["merge", "a", "thrown", "-o", "."]).exits(2).stderr;
    let expected = "results of the scenario `thrown` would be written into the input thrown";
    assert!(over.contains(expected), "{over}");
    assert_eq!([files(&place.path("a")), files(&place.path("thrown"))], before);
    assert!(!place.path("summary.csv").exists());
    // Writing next to the inputs is allowed.
    fs::rename(place.path("thrown"), place.path("b")).unwrap();
    place.runner(&["merge", "a", "b", "-o", "."]).exits(0);
    assert_eq!(place.summary(".").rows.len(), 8 + 6 + 6);
    assert_eq!([files(&place.path("a")), files(&place.path("b"))], before);
}

/// Logs that were moved and replaced by symbolic links are accepted.
#[cfg(unix)]
#[test]
fn files_behind_symbolic_links_are_merged() {
    let place = shards(&[]);
    run(&place, &FILES, &["-o", "whole"]);
    for name in ["log.mcap", "run.json"] {
        let file = first(&place, "b", name);
        let away = place.path(&format!("away-{name}"));
        fs::rename(&file, &away).unwrap();
        std::os::unix::fs::symlink(&away, &file).unwrap();
    }
    let done = merge(&place, &[]);
    assert!(matches!(done.code, Some(0 | 1 | 3)), "{}", done.stderr);
    assert_same(&place.path("whole"), &place.path("merged"));
    let linked = first(&place, "merged", "log.mcap");
    assert!(!linked.is_symlink());
}
