//! What is told before anything is submitted, and what is taken back.

use super::{Site, exists, submit};

/// A sweep that is refused with these words, and of which nothing was submitted.
#[track_caller]
fn refused(site: &Site, more: &[&str], code: i32, words: &str) {
    site.slurm.forget();
    let done = site.runner(&submit("sweep", "3", more)).exits(code);
    assert!(done.stderr.contains(words), "{}", done.stderr);
    let submitted =
        site.slurm.calls().into_iter().any(|call| call[0] == "sbatch" && !call.contains(&"--test-only".into()));
    assert!(!submitted && !exists(site.place.path("sweep/submit/jobs.json")), "{:?}", site.slurm.calls());
}

#[test]
fn scenarios_are_checked_as_run_checks_them() {
    let site = Site::new();
    site.place.block("wrong.toml", "[floor]\nfrction = 0.5\n");
    let told = site.place.runner(&["run", "wrong.toml"]).exits(2);
    let done = site.runner(&submit("sweep", "3", &["wrong.toml"])).exits(2);
    assert_eq!(done.stderr, told.stderr);
    refused(&site, &["nowhere.toml"], 2, "nowhere.toml");
    refused(&site, &["thrown.toml", "--filter", "seed > 5"], 4, "nothing selected");
    refused(&site, &["thrown.toml", "--max-runs", "5"], 2, "5 are allowed");
    assert!(!exists(site.place.path("sweep")));
}

#[test]
fn options_that_make_no_sense_here_are_no_options() {
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
    for taken in [
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
        refused(&site, &["thrown.toml", &format!("--sbatch={taken}")], 2, "cannot be chosen");
    }
    refused(&site, &["thrown.toml", "--sbatch=qos"], 2, "no hyphen before it");
    refused(&site, &["thrown.toml", "--sbatch=--comment=a\n#SBATCH --array=0-99"], 2, "a line break");
    refused(&site, &["thrown.toml", "--partition=a\nrm"], 2, "a line break");
    refused(&site, &["thrown.toml", "--filter", "seed >\n0"], 2, "a line break");
}

#[test]
fn parts_and_processors_are_counts_that_make_sense() {
    let site = Site::new();
    for parts in ["13", "999999999"] {
        let done = site.runner(&submit("sweep", parts, &["thrown.toml", "--dry-run"])).exits(2);
        let words = format!("--parts {parts}: there are 12 runs, and a part without one is a job for nothing");
        assert!(done.stderr.contains(&words), "{}", done.stderr);
    }
    site.runner(&submit("sweep", "12", &["thrown.toml", "--dry-run"])).exits(0);
    for (option, value, words) in [
        ("--parts", "0", "a whole number of 1 or more is wanted"),
        ("--parts", "-1", "a whole number of 1 or more is wanted"),
        ("--parts", "99999999999999999999", "it is larger than any that is taken here"),
        ("--cpus", "0", "a whole number of 1 or more is wanted"),
        ("--cpus", "4294967296", "it is larger than any that is taken here"),
        ("--jobs", "0", "a whole number of 1 or more is wanted"),
    ] {
        let more = if option == "--parts" { vec![] } else { vec!["--parts", "3"] };
        let typed = [&["submit", "--engine", "slurm", "-o", "sweep", "thrown.toml", option, value], &more[..]].concat();
        let done = site.runner(&typed).exits(2);
        assert!(done.stderr.contains(words) && done.stderr.contains(option), "{}", done.stderr);
    }
}

#[test]
fn a_folder_that_cannot_stand_in_a_script_is_refused() {
    let site = Site::new();
    for (folder, words) in
        [("new\nline", "a line break"), ("back\\slash", "a backslash"), ("esc\u{1b}", "a control character")]
    {
        let done = site.runner(&submit(folder, "3", &["thrown.toml"])).exits(2);
        assert!(done.stderr.contains(words), "{}", done.stderr);
        assert!(site.slurm.calls().is_empty() && !exists(site.place.path(folder)));
    }
}

#[test]
fn without_a_cluster_it_says_what_to_do() {
    let site = Site::new();
    site.slurm.set("down", "");
    refused(&site, &["thrown.toml"], 2, "Slurm does not answer: `scontrol show config` ended with exit code 1:");
    refused(&site, &["thrown.toml"], 2, "Unable to contact slurm controller");
    refused(&site, &["thrown.toml"], 2, "scontrol ping");
    site.slurm.unset("down");
    site.slurm.without("scontrol").without("sbatch");
    // A PATH on which only this Slurm is.
    let mut command = site.place.command(&submit("sweep", "3", &["thrown.toml"]));
    let done = crate::cli::Done::from(command.env("PATH", site.place.path("slurm/bin")).output().unwrap()).exits(2);
    assert!(done.stderr.contains("cannot start `scontrol` of Slurm"), "{}", done.stderr);
    assert!(done.stderr.contains("--dry-run"), "{}", done.stderr);
}

#[test]
fn what_the_cluster_does_not_take_is_told() {
    let site = Site::new();
    site.place.block("many.toml", "[sweep]\nrepeat = 1002\n");
    let done = site.runner(&submit("sweep", "1002", &["many.toml"])).exits(2);
    assert!(done.stderr.contains("--parts 1002: Slurm takes at most 1001 here (MaxArraySize"), "{}", done.stderr);
    site.runner(&submit("sweep", "1001", &["many.toml", "--dry-run"])).exits(0);
    site.slurm.set("refuses", "Invalid partition name specified");
    refused(&site, &["thrown.toml", "--partition", "none"], 2, "Invalid partition name specified");
    refused(&site, &["thrown.toml"], 2, "sbatch --test-only");
    refused(&site, &["thrown.toml"], 2, "nothing was submitted");
}

#[test]
fn an_array_that_nothing_would_merge_is_cancelled() {
    let site = Site::new();
    site.slurm.set("refuses-merge", "");
    let done = site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(2);
    assert!(done.stderr.contains("Job dependency problem"), "{}", done.stderr);
    assert!(done.stderr.contains("the job array 41 was cancelled; nothing is left"), "{}", done.stderr);
    assert_eq!(site.slurm.calls().last().unwrap(), &["scancel", "41"]);
    assert!(!exists(site.place.path("sweep/submit/jobs.json")));
    site.slurm.set("keeps", "");
    let done = site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(2);
    assert!(done.stderr.contains("the job array 42 is left and could not be cancelled"), "{}", done.stderr);
    // Then somebody must be able to find it.
    assert_eq!(site.jobs("sweep")["array"], "42");
}
