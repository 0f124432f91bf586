//! Tests of the submitted jobs and their results.

use std::fs;

use super::{Site, exists, real, submit};
use crate::support::same::{assert_same, files};

#[test]
fn merged_results_equal_those_of_one_batch() {
    let site = Site::new();
    let direct = site.place.runner(&["thrown.toml", "-o", "direct"]).exits(1);
    assert!(direct.stdout.contains("failed"), "{}", direct.stdout);
    site.slurm.set("run", "");
    let done = site.runner(&submit("sweep", "3", &["thrown.toml", "--wait"])).exits(1);
    assert!(done.stdout.contains("12 runs in 3 parts: job array 41, then job 42 to merge them"), "{}", done.stdout);
    assert_same(&site.place.path("direct"), &site.place.path("sweep/results"));
    let records = |output: &str| files(&site.place.path(output)).iter().filter(|f| f.ends_with("run.json")).count();
    let parts: Vec<usize> = (0..3).map(|part| records(&format!("sweep/part-{part}"))).collect();
    assert_eq!(parts.iter().sum::<usize>(), 12, "{parts:?}");
    assert!(parts.iter().all(|runs| *runs > 0), "every part has runs: {parts:?}");
    for part in 0..3 {
        let output = site.script("sweep", &format!("task-{part}.txt"));
        assert!(output.contains(&format!("shard {}/3", part + 1)), "{output}");
    }
    assert!(site.script("sweep", "merge.txt").contains("12 runs: "), "{}", site.script("sweep", "merge.txt"));
}

#[test]
fn a_lost_part_is_reported_and_a_second_submission_runs_it() {
    let site = Site::new();
    site.place.runner(&["thrown.toml", "-o", "direct"]).exits(1);
    site.slurm.set("run", "").set("loses", "1");
    let arguments = submit("sweep", "3", &["thrown.toml", "--wait"]);
    let done = site.runner(&arguments).exits(2);
    assert!(done.stderr.contains("sweep/submit/merge.txt"), "{}", done.stderr);
    let output = site.script("sweep", "merge.txt");
    assert!(output.contains("sweep/part-1: no such folder"), "{output}");
    assert!(!exists(site.place.path("sweep/results")));
    site.slurm.unset("loses");
    site.runner(&arguments).exits(1);
    assert_same(&site.place.path("direct"), &site.place.path("sweep/results"));
    // Finished runs are not run again.
    assert!(site.script("sweep", "task-0.txt").contains("resumed: "), "{}", site.script("sweep", "task-0.txt"));
}

#[test]
fn the_engine_is_called_in_order_with_separate_arguments() {
    let site = Site::new();
    let chosen = ["--cpus", "4", "--time", "2:00:00", "--partition", "long", "--account", "lab", "--mem", "2G"];
    let more = ["--sbatch=--qos=low", "--sbatch", "--constraint=avx2"];
    let run = [
        "--set",
        "gravty=[0, 0, -9.8]",
        "--filter",
        "seed == 1",
        "--no-log",
        "--durable",
        "--timeout",
        "1.5",
        "--jobs",
        "3",
    ];
    let options: Vec<&str> = [&["thrown.toml", "--strict"][..], &chosen, &more, &run].concat();
    let done = site.runner(&submit("sweep", "2", &options)).exits(2);
    assert!(done.stderr.contains("gravty"), "{}", done.stderr);
    assert!(site.slurm.calls().is_empty(), "invalid scenarios need no cluster");
    let options: Vec<&str> = options.iter().map(|word| word.replace("gravty", "gravity").leak() as &str).collect();
    let done = site.runner(&submit("sweep", "2", &options)).exits(0);
    let script = |name: &str| real(site.place.path("sweep/submit")).join(name).display().to_string();
    let calls = site.slurm.calls();
    let expected: Vec<Vec<String>> = [
        vec!["scontrol", "show", "config"],
        vec!["sbatch", "--test-only", &script("array.sbatch")],
        vec!["sbatch", "--test-only", &script("merge.sbatch")],
        vec!["sbatch", "--parsable", &script("array.sbatch")],
        vec!["sbatch", "--parsable", "--dependency=afterany:41", &script("merge.sbatch")],
    ]
    .into_iter()
    .map(|call| call.into_iter().map(str::to_owned).collect())
    .collect();
    assert_eq!(calls, expected);
    assert!(done.stdout.contains("job array 41, then job 42"), "{}", done.stdout);
    let array = site.script("sweep", "array.sbatch");
    let folder = real(site.place.path("sweep")).display().to_string();
    for line in [
        "#SBATCH --array=0-1",
        "#SBATCH --cpus-per-task=4",
        "#SBATCH --signal=B:INT@60",
        "#SBATCH --requeue",
        "#SBATCH --open-mode=append",
        "#SBATCH --time=\"2:00:00\"",
        "#SBATCH --partition=\"long\"",
        "#SBATCH --account=\"lab\"",
        "#SBATCH --mem=\"2G\"",
        "#SBATCH --qos=low",
        "#SBATCH --constraint=avx2",
        &format!("#SBATCH --output=\"{folder}/submit/task-%a.txt\""),
    ] {
        assert!(array.lines().any(|found| found == line), "{line} in\n{array}");
    }
    let exec = array.lines().last().unwrap();
    let scenario = real(site.place.path("thrown.toml")).display().to_string();
    let end = format!(
        "--no-log --durable --timeout=1.5 '--set=gravity=[0, 0, -9.8]' '--filter=seed == 1' --strict {scenario} --shard env --resume \
         --jobs 3 --output {folder}/part-\"$SLURM_ARRAY_TASK_ID\""
    );
    assert!(exec.starts_with(&format!("exec {} run ", env!("CARGO_BIN_EXE_runner"))) && exec.ends_with(&end), "{exec}");
    let merge = site.script("sweep", "merge.sbatch");
    assert!(
        merge.ends_with(&format!(" merge {folder}/part-0 {folder}/part-1 --durable --output {folder}/results\n")),
        "{merge}"
    );
    assert!(merge.contains("#SBATCH --partition=\"long\"") && !merge.contains("--array"), "{merge}");
    let jobs = site.jobs("sweep");
    assert_eq!((&jobs["array"], &jobs["merge"]), (&"41".into(), &"42".into()));
    assert_eq!((&jobs["parts"], &jobs["runs"], &jobs["engine"]), (&2.into(), &6.into(), &"slurm".into()));
    assert!(jobs["command"].as_array().unwrap().contains(&"--filter=seed == 1".into()), "{jobs}");
    // The hash of the plan is that of the parts.
    site.place
        .runner(&["thrown.toml", "--set=gravity=[0, 0, -9.8]", "--filter", "seed == 1", "--shard", "1/2"])
        .exits(1);
    let head = fs::read_to_string(site.place.path("results/shard.jsonl")).unwrap();
    let head: serde_json::Value = serde_json::from_str(head.lines().next().unwrap()).unwrap();
    assert_eq!(head["plan"], jobs["plan"]);
}

#[test]
fn names_with_shell_syntax_are_quoted() {
    for name in ["a b", "it's", "say \"x\"", "$HOME `id` $(id)", "-x;y&z|*?", "%a 100%", "größe # ~"] {
        let site = Site::new();
        let at = |file: &str| format!("{name}/{file}");
        // Scenario and results are in a folder of this name.
        let robot = site.place.path("block/block.toml");
        fs::create_dir_all(site.place.path(name)).unwrap();
        let text = fs::read_to_string(site.place.path("thrown.toml")).unwrap();
        let text = text.replace("\"block/block.toml\"", &format!("{:?}", robot.display().to_string()));
        site.place.write(&at("thrown.toml"), text);
        site.place.runner(&["run", &format!("./{}", at("thrown.toml")), "-o", "direct"]).exits(1);
        site.slurm.set("run", "");
        let (scenario, output) = (format!("./{}", at("thrown.toml")), format!("./{}", at("sweep")));
        let filter = "--filter=name ~ \"thr*\" and seed > 0";
        site.runner(&submit(&output, "2", &[&scenario, filter, "--wait"])).exits(1);
        assert_same(&site.place.path("direct"), &site.place.path(&at("sweep/results")));
        assert!(exists(site.place.path(&at("sweep/submit/task-1.txt"))), "{name}");
    }
}

#[test]
fn a_dry_run_needs_no_cluster_and_submits_nothing() {
    let site = Site::new();
    site.slurm.set("down", "");
    site.place.block("many.toml", "[sweep]\nrepeat = 1002\n");
    let done = site.runner(&submit("sweep", "1002", &["many.toml", "--dry-run"])).exits(0);
    assert!(site.slurm.calls().is_empty(), "{:?}", site.slurm.calls());
    assert!(done.stdout.contains("1002 runs in 1002 parts"), "{}", done.stdout);
    assert!(done.stdout.contains("sbatch --dependency=afterany:ARRAY "), "{}", done.stdout);
    assert!(site.script("sweep", "array.sbatch").contains("--array=0-1001"));
    assert!(!exists(site.place.path("sweep/submit/jobs.json")));
    // The sweep can be submitted afterwards.
    site.slurm.unset("down");
    site.runner(&submit("sweep", "2", &["many.toml"])).exits(0);
}

/// Neither four passed runs nor a search without a boundary show anything.
#[test]
fn waiting_ends_as_undecided_with_the_merge() {
    let claim = "[[claim]]\nname = \"passes\"\nshare = { outcome = \"passed\" }\nat_least = 0.9\n[sweep]\nrepeat = 4\n";
    let search = "[search]\nboundary = { outcome = \"fallen\" }\n\
        over = { \"duration\" = { between = [0.01, 0.02], tolerance = 0.001 } }\n[sweep]\nrepeat = 3\n";
    for (text, parts) in [(claim, "2"), (search, "3")] {
        let site = Site::new();
        site.place.block("open.toml", text);
        site.slurm.set("run", "");
        site.runner(&submit("sweep", parts, &["open.toml", "--wait"])).exits(5);
        let merged = site.script("sweep", "merge.txt");
        assert!(merged.contains("undecided") || merged.contains("no-boundary"), "{merged}");
    }
}
