//! Merged shards equal one batch.

use std::fs;

use stiction::results::RunRecord;

use super::{FILES, REFERENCES, RUNS, run, scenarios};
use crate::cli::Place;
use crate::support::same::{assert_same, files};

/// Runs all shards of the scenarios, each with a different number of threads.
fn shards(place: &Place, of: usize) -> Vec<String> {
    let names: Vec<String> = (1..=of).map(|i| format!("shard-{i}")).collect();
    for (i, name) in names.iter().enumerate() {
        let shard = format!("{}/{of}", i + 1);
        run(place, &FILES, &["--shard", &shard, "-j", &(i + 1).to_string(), "-o", name]);
    }
    names
}

fn merge<'a>(shards: &[&'a str], output: &'a str) -> Vec<&'a str> {
    [&["merge"], shards, &["--output", output]].concat()
}

#[test]
fn merged_shards_equal_one_batch() {
    let place = scenarios();
    run(&place, &FILES, &["-o", "whole"]);
    let shards = shards(&place, 4);
    let names: Vec<&str> = shards.iter().map(String::as_str).collect();
    let rows: Vec<usize> = names.iter().map(|name| place.summary(name).rows.len()).collect();
    assert_eq!(rows.iter().sum::<usize>(), RUNS);
    assert!(rows.iter().all(|n| (1..RUNS).contains(n)), "every shard has some: {rows:?}");
    let done = place.runner(&merge(&names, "merged")).exits(0);
    assert!(done.stdout.contains(&format!("{RUNS} runs: ")), "{}", done.stdout);
    assert_same(&place.path("whole"), &place.path("merged"));
    // In any order of the inputs, and over existing output.
    let reversed: Vec<&str> = names.iter().rev().copied().collect();
    place.runner(&merge(&reversed, "merged")).exits(0);
    assert_same(&place.path("whole"), &place.path("merged"));
    // The merged results do not need the folders of the shards.
    names.iter().for_each(|name| fs::remove_dir_all(place.path(name)).unwrap());
    assert_same(&place.path("whole"), &place.path("merged"));
    assert_eq!(files(&place.path("merged")).iter().filter(|f| f.ends_with("run.json")).count(), RUNS + REFERENCES);
}

#[test]
fn a_run_stays_in_its_shard_whichever_runs_are_in_the_batch() {
    let place = scenarios();
    let keys = |arguments: &[&str]| -> Vec<String> {
        let done = place.runner(&[&["list", "--format", "csv"], arguments].concat()).exits(0);
        let table = crate::cli::Table::parse(&done.stdout);
        table.column("key").iter().map(|key| key.to_string()).collect()
    };
    let all = keys(&FILES);
    let mut seen = Vec::new();
    for i in 1..=3 {
        let shard = format!("{i}/3");
        let part = keys(&[&FILES[..], &["--shard", &shard]].concat());
        let ordered: Vec<&String> = all.iter().filter(|key| part.contains(key)).collect();
        assert_eq!(part.iter().collect::<Vec<_>>(), ordered, "in the order of the whole");
        // With fewer files, the remaining runs stay in the same shards.
        let few = keys(&["thrown.toml", "--shard", &shard]);
        let of_thrown = keys(&["thrown.toml"]);
        assert_eq!(few, part.iter().filter(|key| of_thrown.contains(key)).cloned().collect::<Vec<_>>());
        seen.extend(part);
    }
    seen.sort();
    let mut sorted = all.clone();
    sorted.sort();
    assert_eq!(seen, sorted);
}

#[test]
fn shard_env_reads_the_index_of_the_job_array() {
    let place = scenarios();
    let list = |shard: &str, variables: &[(&str, &str)]| {
        let mut command = place.command(&["list", "thrown.toml", "--shard", shard]);
        command.env_remove("SLURM_ARRAY_TASK_ID").env_remove("JOB_COMPLETION_INDEX").envs(variables.iter().copied());
        crate::cli::Done::from(command.output().unwrap())
    };
    let array = [("SLURM_ARRAY_TASK_ID", "2"), ("SLURM_ARRAY_TASK_MIN", "1"), ("SLURM_ARRAY_TASK_COUNT", "3")];
    let second = list("2/3", &[]).exits(0);
    let from_env = list("env", &array).exits(0);
    assert_eq!((&from_env.stdout, &from_env.stderr), (&second.stdout, &second.stderr));
    assert_eq!(
        list("1/3", &array).exits(0).stdout,
        list("1/3", &[]).exits(0).stdout,
        "the environment counts only with `env`"
    );
    assert!(list("env", &[]).exits(2).stderr.contains("neither SLURM_ARRAY_TASK_ID nor JOB_COMPLETION_INDEX"));
    assert!(list("4/3", &[]).exits(2).stderr.contains("there is no part 4 of 3"));
}

#[test]
fn missing_results_are_reported_and_nothing_is_written() {
    let place = scenarios();
    let shards = shards(&place, 3);
    let names: Vec<&str> = shards.iter().map(String::as_str).collect();
    let done = place.runner(&merge(&names[..1], "merged")).exits(2);
    assert!(done.stderr.contains("error: 2 of 3 shards are missing: 2, 3"), "{}", done.stderr);
    assert!(!place.path("merged").exists());
    // As if the run had been killed with its shard.
    let lost = place.summary("shard-2").column("key")[0].to_owned();
    let scenario = place.summary("shard-2").column("scenario")[0].to_owned();
    fs::remove_file(place.path("shard-2").join(&scenario).join(&lost).join("run.json")).unwrap();
    let done = place.runner(&merge(&names, "merged")).exits(2);
    let error = format!("error: shard-2 (shard 2/3) has no result of 1 of its runs: {scenario} {lost}");
    assert!(done.stderr.contains(&error), "{}", done.stderr);
    assert!(done.stderr.contains("--resume") && !place.path("merged").exists(), "{}", done.stderr);
    let done = place.runner(&[&merge(&names, "merged")[..], &["--partial"]].concat()).exits(0);
    assert!(done.stderr.contains("warning: shard-2"), "{}", done.stderr);
    assert_eq!(place.summary("merged").rows.len(), RUNS - 1);
    // After completing the shard, all results are present.
    run(&place, &FILES, &["--shard", "2/3", "-o", "shard-2", "--resume"]);
    place.runner(&merge(&names, "merged")).exits(0);
    run(&place, &FILES, &["-o", "whole"]);
    assert_same(&place.path("whole"), &place.path("merged"));
}

#[test]
fn results_that_do_not_belong_together_are_refused() {
    let place = scenarios();
    let shards = shards(&place, 2);
    let names: Vec<&str> = shards.iter().map(String::as_str).collect();
    let refused = |folders: &[&str], message: &str| {
        let done = place.runner(&merge(folders, "merged")).exits(2);
        assert!(done.stderr.contains(message), "{}", done.stderr);
        assert!(!place.path("merged").exists());
    };
    run(&place, &FILES[..1], &["-o", "plain"]);
    refused(&["shard-1", "plain"], "plain: not the results of a shard: shard.jsonl is missing");
    run(&place, &FILES[..1], &["-o", "fewer", "--shard", "2/2"]);
    refused(&["shard-1", "fewer"], "shard-1 and fewer are not shards of one plan: the plans have 21 and 8 runs");
    run(&place, &FILES, &["-o", "other", "--shard", "2/2", "--set", "gravity=[0, 0, -9.8]"]);
    refused(&["shard-1", "other"], "their scenarios, values, robots or other files differ");
    run(&place, &FILES, &["-o", "third", "--shard", "2/3"]);
    refused(&["shard-1", "third"], "one of 2 and one of 3");
    let done = place.runner(&merge(&names, "shard-1")).exits(2);
    assert!(done.stderr.contains("shard-1: the output folder is one of the inputs"), "{}", done.stderr);
    // The same shard twice is accepted, unless the copies differ.
    run(&place, &FILES, &["-o", "again", "--shard", "2/2"]);
    place.runner(&merge(&["shard-1", "shard-2", "again"], "twice")).exits(0);
    assert_eq!(place.summary("twice").rows.len(), RUNS);
    let key = place.summary("again").column("key")[0].to_owned();
    let scenario = place.summary("again").column("scenario")[0].to_owned();
    let path = place.path("again").join(&scenario).join(&key).join("run.json");
    let mut record = RunRecord::read(&path).unwrap();
    record.metrics.steps += 1;
    record.write(&path).unwrap();
    let steps = format!("metrics.steps is {} and {}", record.metrics.steps - 1, record.metrics.steps);
    refused(&["shard-1", "shard-2", "again"], "1 runs differ between folders:");
    refused(&["shard-1", "shard-2", "again"], &format!("{scenario} {key}: {steps} in shard-2 and again"));
    // Every shard computes the references it needs; differences between machines show there.
    let reference = |name: &str| {
        let below = files(&place.path(name)).into_iter().find(|f| f.contains("references/") && f.ends_with("run.json"));
        place.path(name).join(below.expect("every shard has a run that is compared"))
    };
    let path = reference("shard-2");
    let (original, mut record) = (fs::read(&path).unwrap(), RunRecord::read(&path).unwrap());
    record.metrics.final_base_position[0] += 1e-16;
    record.metrics.steps += 1;
    record.write(&path).unwrap();
    let done = place.runner(&merge(&names, "merged"));
    // An error only if the other shard needs the same reference.
    let shared = place.path("shard-1").join(path.strip_prefix(place.path("shard-2")).unwrap()).is_file();
    assert_eq!(done.code, Some(if shared { 2 } else { 0 }), "{}", done.stderr);
    assert!(!shared || done.stderr.contains("do not compute the same bits"), "{}", done.stderr);
    fs::write(&path, original).unwrap();
}

/// A part plans its own runs of a large sweep only, and they are those of the whole plan.
#[test]
fn a_part_of_a_large_sweep_has_its_runs_of_the_whole() {
    let place = Place::new();
    // The method and the friction are swept, so parts differ in what their runs use.
    place.block(
        "s.toml",
        "[contact.penalty]\nstiffness = 1e6\n[sweep]\nrepeat = 25001\n[sweep.grid]\n\
         \"contact.method\" = [\"exact\", \"penalty\"]\n\"floor.friction\" = [0.2, 0.4]\n",
    );
    let list = |more: &[&str]| {
        let arguments = ["list", "s.toml", "--format", "csv", "--max-runs", "200000"];
        let done = place.runner(&[&arguments[..], more].concat()).exits(0);
        (done.stdout.lines().skip(1).map(str::to_owned).collect::<Vec<_>>(), done.stderr)
    };
    let parts = ["1/1000", "77/1000", "1000/1000"].map(|shard| list(&["--shard", shard]));
    for (own, text) in &parts {
        assert!((100..=101).contains(&own.len()), "{}", own.len());
        assert!(text.contains(" runs of 100004\n") && !text.contains("no effect"), "{text}");
    }
    // With a filter the whole plan is made, of which the part is taken.
    let (filtered, _) = list(&["--shard", "77/1000", "--filter", "seed > 0"]);
    assert_eq!(parts[1].0, filtered);
}

/// Without the whole plan, a part does not see that a run of another part is the same.
#[test]
fn equal_runs_of_different_parts_do_not_merge() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 4\n");
    for part in ["1/2", "2/2"] {
        place.runner(&["s.toml", "--no-log", "--set", "duration=0.02", "--shard", part, "-o", &part[..1]]).exits(0);
    }
    let list = place.path("2/shard.jsonl");
    let text = fs::read_to_string(&list).unwrap();
    let key = |text: &str| text.split_once("\"key\":\"").unwrap().1[..16].to_owned();
    let other = key(&fs::read_to_string(place.path("1/shard.jsonl")).unwrap());
    fs::write(&list, text.replace(&key(&text), &other)).unwrap();
    let done = place.runner(&merge(&["1", "2"], "merged")).exits(2);
    assert!(done.stderr.contains(" of the plan are the same: s ") && done.stderr.contains(&other), "{}", done.stderr);
    assert!(!place.path("merged").exists());
    // A damaged line is named.
    let lines: Vec<&str> = text.lines().collect();
    fs::write(&list, [lines[0], lines[1], "{\"at\": ?", ""].join("\n")).unwrap();
    let done = place.runner(&merge(&["1", "2"], "merged")).exits(2);
    assert!(done.stderr.contains("2/shard.jsonl: line 3, column 8: expected value\n"), "{}", done.stderr);
}

/// Parts whose machines have different files of one name do not merge.
#[test]
fn parts_with_different_files_do_not_merge() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 4\n");
    let run = |part: &str| {
        place.runner(&["s.toml", "--no-log", "--set", "duration=0.02", "--shard", part, "-o", &part[..1]]).exits(0)
    };
    run("1/2");
    let robot = fs::read_dir(place.path("block")).unwrap().flatten().map(|e| e.path());
    let robot = robot.into_iter().find(|path| path.extension().is_some_and(|e| e == "urdf")).expect("the block");
    fs::write(&robot, fs::read_to_string(&robot).unwrap() + "<!-- changed -->\n").unwrap();
    run("2/2");
    let done = place.runner(&merge(&["1", "2"], "merged")).exits(2);
    assert!(done.stderr.contains("1 and 2 are not shards of one plan: a file differs: s: "), "{}", done.stderr);
    assert!(!place.path("merged").exists());
}

#[test]
fn a_shard_may_be_empty() {
    let place = Place::new();
    place.block("s.toml", "");
    let own = [1, 2].map(|i| {
        let (shard, output) = (format!("{i}/2"), format!("shard-{i}"));
        let done = place.runner(&["s.toml", "--set", "duration=5", "--shard", &shard, "-o", &output]).exits(0);
        done.stderr.contains(&format!("shard {shard}: 1 run of 1"))
    });
    assert!(own[0] != own[1]);
    place.runner(&merge(&["shard-1", "shard-2"], "merged")).exits(0);
    assert_eq!(place.summary("merged").rows.len(), 1);
}
