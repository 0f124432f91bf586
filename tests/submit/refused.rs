//! Tests of errors before a submission, and of jobs cancelled after one.

use super::{Site, exists, submit};

/// Asserts that a sweep is refused with this text and that nothing was submitted.
#[track_caller]
fn refused(site: &Site, more: &[&str], code: i32, text: &str) {
    site.slurm.clear_calls();
    let done = site.runner(&submit("sweep", "3", more)).exits(code);
    assert!(done.stderr.contains(text), "{}", done.stderr);
    let submitted =
        site.slurm.calls().into_iter().any(|call| call[0] == "sbatch" && !call.contains(&"--test-only".into()));
    assert!(!submitted && !exists(site.place.path("sweep/submit/jobs.json")), "{:?}", site.slurm.calls());
}

#[test]
fn scenarios_are_checked_as_by_run() {
    let site = Site::new();
    site.place.block("wrong.toml", "[floor]\nfrction = 0.5\n");
    let direct = site.place.runner(&["run", "wrong.toml"]).exits(2);
    let done = site.runner(&submit("sweep", "3", &["wrong.toml"])).exits(2);
    assert_eq!(done.stderr, direct.stderr);
    refused(&site, &["nowhere.toml"], 2, "nowhere.toml");
    refused(&site, &["thrown.toml", "--filter", "seed > 5"], 4, "nothing selected");
    refused(&site, &["thrown.toml", "--max-runs", "5"], 2, "5 are allowed");
    assert!(!exists(site.place.path("sweep")));
}

#[test]
fn options_without_meaning_are_refused() {
    let site = Site::new();
    for wrong in [
        &["--shard", "1/2"][..],
        &["--message-format", "json"],
        &["--output", "other"],
        &["--junit", "x.xml"],
        &["--max-fail", "1"],
        &["--dry-run", "--wait"],
        &["--parts", "3"],
    ] {
        refused(&site, &[&["thrown.toml"], wrong].concat(), 2, wrong[0].trim_start_matches("--dry-run"));
        assert!(site.slurm.calls().is_empty());
    }
    for none in
        [&["submit", "thrown.toml", "--engine", "slurm", "-o", "sweep", "--parts", "0"][..], &["submit", "thrown.toml"]]
    {
        site.runner(none).exits(2);
    }
    for reserved in [
        "--array=3",
        "-a3",
        "--dependency=afterok:1",
        "-d singleton",
        "--qos=low --wait",
        "--output=x",
        "-Mother",
        "--arr=3",
        "--out=x",
        "--dep=x",
    ] {
        refused(&site, &["thrown.toml", &format!("--sbatch={reserved}")], 2, "cannot be chosen");
    }
    refused(&site, &["thrown.toml", "--sbatch=qos"], 2, "no hyphen before it");
    refused(&site, &["thrown.toml", "--sbatch=--comment=a\n#SBATCH --array=0-99"], 2, "a line break");
    refused(&site, &["thrown.toml", "--partition=a\nrm"], 2, "a line break");
    refused(&site, &["thrown.toml", "--filter", "seed >\n0"], 2, "a line break");
}

#[test]
fn parts_and_processors_are_positive_counts() {
    let site = Site::new();
    for parts in ["13", "999999999"] {
        let done = site.runner(&submit("sweep", parts, &["thrown.toml", "--dry-run"])).exits(2);
        let text = format!("--parts {parts}: there are 12 runs, and a part without a run needs no job");
        assert!(done.stderr.contains(&text), "{}", done.stderr);
    }
    site.runner(&submit("sweep", "12", &["thrown.toml", "--dry-run"])).exits(0);
    for (option, value, text) in [
        ("--parts", "0", "expected a whole number of at least 1"),
        ("--parts", "-1", "expected a whole number of at least 1"),
        ("--parts", "99999999999999999999", "the number is too large"),
        ("--cpus", "0", "expected a whole number of at least 1"),
        ("--cpus", "4294967296", "the number is too large"),
        ("--jobs", "0", "expected a whole number of at least 1"),
    ] {
        let more = if option == "--parts" { vec![] } else { vec!["--parts", "3"] };
        let typed = [&["submit", "--engine", "slurm", "-o", "sweep", "thrown.toml", option, value], &more[..]].concat();
        let done = site.runner(&typed).exits(2);
        assert!(done.stderr.contains(text) && done.stderr.contains(option), "{}", done.stderr);
    }
}

#[test]
fn a_folder_that_a_script_cannot_name_is_refused() {
    let site = Site::new();
    for (folder, text) in
        [("new\nline", "a line break"), ("back\\slash", "a backslash"), ("esc\u{1b}", "a control character")]
    {
        let done = site.runner(&submit(folder, "3", &["thrown.toml"])).exits(2);
        assert!(done.stderr.contains(text), "{}", done.stderr);
        assert!(site.slurm.calls().is_empty() && !exists(site.place.path(folder)));
    }
}

#[test]
fn without_a_cluster_the_error_suggests_a_dry_run() {
    let site = Site::new();
    site.slurm.set("down", "");
    refused(&site, &["thrown.toml"], 2, "Slurm does not answer: `scontrol show config` ended with exit code 1:");
    refused(&site, &["thrown.toml"], 2, "Unable to contact slurm controller");
    refused(&site, &["thrown.toml"], 2, "scontrol ping");
    site.slurm.unset("down");
    site.slurm.without("scontrol").without("sbatch");
    // A PATH with nothing but this Slurm.
    let mut command = site.place.command(&submit("sweep", "3", &["thrown.toml"]));
    let done = crate::cli::Done::from(command.env("PATH", site.place.path("slurm/bin")).output().unwrap()).exits(2);
    assert!(done.stderr.contains("cannot start `scontrol` of Slurm"), "{}", done.stderr);
    assert!(done.stderr.contains("--dry-run"), "{}", done.stderr);
}

#[test]
fn limits_and_errors_of_the_cluster_are_reported() {
    let site = Site::new();
    site.place.block("many.toml", "[sweep]\nrepeat = 1002\n");
    let done = site.runner(&submit("sweep", "1002", &["many.toml"])).exits(2);
    assert!(done.stderr.contains("--parts 1002: Slurm accepts at most 1001 here (MaxArraySize"), "{}", done.stderr);
    site.runner(&submit("sweep", "1001", &["many.toml", "--dry-run"])).exits(0);
    site.slurm.set("rejects", "Invalid partition name specified");
    refused(&site, &["thrown.toml", "--partition", "none"], 2, "Invalid partition name specified");
    refused(&site, &["thrown.toml"], 2, "sbatch --test-only");
    refused(&site, &["thrown.toml"], 2, "nothing was submitted");
}

#[test]
fn an_array_without_a_merge_is_cancelled() {
    let site = Site::new();
    site.slurm.set("rejects-merge", "");
    let done = site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(2);
    assert!(done.stderr.contains("Job dependency problem"), "{}", done.stderr);
    assert!(done.stderr.contains("the job array 41 was cancelled"), "{}", done.stderr);
    assert_eq!(site.slurm.calls().last().unwrap(), &["scancel", "41"]);
    assert!(!exists(site.place.path("sweep/submit/jobs.json")));
    site.slurm.set("keeps", "");
    let done = site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(2);
    assert!(done.stderr.contains("the job array 42 remains and could not be cancelled"), "{}", done.stderr);
    // jobs.json still names it, so the user can find it.
    assert_eq!(site.jobs("sweep")["array"], "42");
}
