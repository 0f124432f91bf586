//! Tests of submissions into folders that already contain jobs or results.

use std::process::Stdio;

use super::{Site, exists, submit};
use crate::cli::Done;

/// Asserts that a submission is refused because of other results in the folder.
#[track_caller]
fn refused(site: &Site, parts: &str, more: &[&str], text: &str) {
    site.slurm.clear_calls();
    let done = site.runner(&submit("sweep", parts, more)).exits(2);
    assert!(done.stderr.contains(text), "{}", done.stderr);
    assert!(done.stderr.contains("give this sweep another folder with -o"), "{}", done.stderr);
    assert!(site.slurm.calls().is_empty(), "{:?}", site.slurm.calls());
}

#[test]
fn another_plan_or_number_of_parts_is_refused() {
    let site = Site::new();
    site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(0);
    let scripts = site.script("sweep", "array.sbatch");
    let (set, filter) = (["thrown.toml", "--set", "gravity=[0, 0, -9.8]"], ["thrown.toml", "--filter", "seed == 1"]);
    // First known from jobs.json, then from the parts only.
    for of in ["submitted", "part-1"] {
        if of == "part-1" {
            site.slurm.set("run", "");
            site.runner(&submit("sweep", "3", &["thrown.toml", "--wait"])).exits(1);
            std::fs::remove_file(site.place.path("sweep/submit/jobs.json")).unwrap();
        }
        let number =
            if of == "part-1" { "its part-0 is part 1 of 3, not of 4" } else { "it was submitted in 3 parts, not 4" };
        refused(&site, "4", &["thrown.toml"], number);
        refused(&site, "3", &set, "the submission there has other scenarios, values, robots, files or --filter");
        refused(&site, "3", &filter, "the submission there has 12 runs, this one has 6");
        // Also with --dry-run.
        refused(&site, "4", &["thrown.toml", "--dry-run"], number);
    }
    assert_eq!(site.script("sweep", "array.sbatch"), scripts);
    site.slurm.unset("run");
    site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(0);
}

#[test]
fn jobs_that_have_not_ended_are_not_submitted_again() {
    let site = Site::new();
    site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(0);
    site.slurm.set("alive", "41 RUNNING\n41 PENDING\n42 PENDING\n");
    site.slurm.clear_calls();
    let done = site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(2);
    assert!(done.stderr.contains("have not ended yet (41 pending, 41 running, 42 pending)"), "{}", done.stderr);
    assert!(done.stderr.contains("`scancel 41 42`"), "{}", done.stderr);
    assert_eq!(site.slurm.called(), ["scontrol", "squeue"]);
    assert!(site.slurm.calls()[1].contains(&"--jobs=41,42".to_owned()));
    site.slurm.unset("alive");
    site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(0);
    assert_eq!(site.jobs("sweep")["array"], "43");
}

#[test]
fn other_results_are_refused() {
    let site = Site::new();
    site.place.runner(&["thrown.toml", "-o", "sweep/results"]).exits(1);
    refused(&site, "3", &["thrown.toml"], "it has a folder `results` that no earlier submission wrote");
    assert!(!exists(site.place.path("sweep/submit")));
    // The folder of a batch, and of a part.
    for (more, name) in [(&["-o", "batch"][..], "runs.jsonl"), (&["-o", "part", "--shard", "1/2"], "shard.jsonl")] {
        site.place.runner(&[&["thrown.toml"], more].concat()).exits(1);
        let done = site.runner(&submit(more[1], "3", &["thrown.toml"])).exits(2);
        let message = format!("it is a folder of results: it has a {name}; give this sweep another folder with -o");
        assert!(done.stderr.contains(&message), "{}", done.stderr);
        assert!(!exists(site.place.path(more[1]).join("submit")));
    }
}

/// Does not follow symbolic links, and does not block on a pipe.
#[cfg(unix)]
#[test]
fn links_and_pipes_in_the_folder_are_refused() {
    for (name, text) in [("submit", "a symbolic link"), ("part-0", "a symbolic link"), ("results", "a symbolic link")] {
        let site = Site::new();
        std::fs::create_dir_all(site.place.path("sweep")).unwrap();
        std::fs::create_dir_all(site.place.path("away")).unwrap();
        std::os::unix::fs::symlink(site.place.path("away"), site.place.path("sweep").join(name)).unwrap();
        let done = site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(2);
        assert!(done.stderr.contains(text), "{name}: {}", done.stderr);
        assert_eq!(std::fs::read_dir(site.place.path("away")).unwrap().count(), 0);
    }
    let site = Site::new();
    std::fs::create_dir_all(site.place.path("sweep/submit")).unwrap();
    let pipe = site.place.path("sweep/submit/jobs.json");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let done = site.runner(&submit("sweep", "3", &["thrown.toml"])).exits(2);
    assert!(done.stderr.contains("jobs.json"), "{}", done.stderr);
}

#[test]
fn of_submissions_at_once_one_is_accepted() {
    const PROGRAMS: usize = 6;
    let site = Site::new();
    // As long as the jobs of the first have not ended.
    site.slurm.set("alive", "41 RUNNING\n42 PENDING\n");
    let arguments = submit("sweep", "3", &["thrown.toml"]);
    let start = |_| {
        let mut command = site.place.command(&arguments);
        site.slurm.put_on_path(&mut command);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let all: Vec<_> = (0..PROGRAMS).map(start).collect();
    let done: Vec<Done> = all.into_iter().map(|child| Done::from(child.wait_with_output().unwrap())).collect();
    let refused = |done: &&Done| done.code == Some(2) && done.stderr.contains("its jobs have not ended yet");
    let errors: Vec<&String> = done.iter().map(|done| &done.stderr).collect();
    assert_eq!(done.iter().filter(refused).count(), PROGRAMS - 1, "{errors:?}");
    assert_eq!(done.iter().filter(|done| done.code == Some(0)).count(), 1, "{errors:?}");
    let submitted = site.slurm.calls().into_iter().filter(|call| call.contains(&"--parsable".to_owned()));
    assert_eq!(submitted.count(), 2, "the array and the merge of one submission");
}
