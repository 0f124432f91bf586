//! Tests of the files of a batch, their contents, and keys.

use std::fs;

use super::{Place, Table};
use stiction::log::ProblemRecord;
use stiction::results::RunRecord;

#[test]
fn a_batch_writes_its_files_and_lists_them() {
    let place = Place::new();
    place.block(
        "slide.toml",
        "base = { linear_velocity = [1, 0, 0] }\n[sweep]\ngrid = { \"floor.friction\" = [0.5, 0.25] }\n",
    );
    place.block("rest.toml", "[log]\nrate = 0\n");
    let done = place.runner(&["slide.toml", "rest.toml", "--set", "duration=0.5", "-o", "deep/out", "-v"]).exits(0);
    let summary = place.summary("deep/out");
    assert_eq!(summary.column("scenario"), ["slide", "slide", "rest"]);
    assert_eq!(summary.column("floor.friction"), ["0.5", "0.25", ""]);
    // At 0.5 s both rest after v^2 / (2 mu g). Friction is constant until then, so the integrator
    // is exact. The remaining error comes from the speed below which a block counts as resting.
    let x = summary.numbers("final_base_x");
    for (x, mu) in x.iter().zip([0.5, 0.25]) {
        let stop = 1.0 / (2.0 * mu * 9.81);
        assert!((x - stop).abs() < 1e-6, "{x} is not {stop}");
    }

    for name in ["summary.csv", "summary.parquet", "runs.jsonl"] {
        assert!(place.path("deep/out").join(name).is_file(), "{name}");
        assert!(done.stdout.contains(&format!("deep/out/{name}")), "{}", done.stdout);
    }
    for (scenario, key) in summary.column("scenario").into_iter().zip(summary.column("key")) {
        let folder = place.path("deep/out").join(scenario).join(key);
        let record = RunRecord::read(&folder.join("run.json")).unwrap();
        assert_eq!((record.scenario.as_str(), record.key.as_str()), (scenario, key));
        assert_eq!(record.inputs.iter().map(|i| i.name.as_str()).collect::<Vec<_>>(), ["block.toml", "block.urdf"]);
        assert!(record.resolved.contains("duration = 0.5"), "{}", record.resolved);
        assert!(record.timing.wall_s > 0.0 && record.timing.cpu_s > 0.0, "{:?}", record.timing);
        assert_eq!(folder.join("log.mcap").is_file(), scenario == "slide", "rate = 0 means no log");
        assert!(done.stdout.contains(&format!("deep/out/{scenario}/{key}/run.json")), "{}", done.stdout);
    }
    let lines = fs::read_to_string(place.path("deep/out/runs.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 3);
    assert!(done.stderr.contains("3 runs, "), "the number of runs is printed before the start: {}", done.stderr);
    assert!(done.stderr.contains("[3/3] "), "one line per run: {}", done.stderr);
}

#[test]
fn no_log_changes_only_the_log() {
    let place = Place::new();
    place.block("drop.toml", "base = { position = [0, 0, 0.2], linear_velocity = [0.5, 0, 0] }\n");
    place.runner(&["drop.toml", "--set", "duration=1", "-o", "with"]).exits(0);
    place.runner(&["drop.toml", "--set", "duration=1", "-o", "without", "--no-log"]).exits(0);
    let (with, without) = (place.summary("with"), place.summary("without"));
    let folder = |results: &str, t: &Table| place.path(results).join("drop").join(t.column("key")[0]);
    assert!(folder("with", &with).join("log.mcap").exists());
    assert!(!folder("without", &without).join("log.mcap").exists());
    // Each instant of a log costs an evaluation.
    let differ = ["wall_s", "cpu_s", "real_time_factor", "evaluations"];
    for name in with.header.iter().filter(|h| !differ.contains(&h.as_str())) {
        assert_eq!(with.column(name), without.column(name), "{name}");
    }
}

#[test]
fn results_go_to_stdout_and_progress_to_stderr() {
    let place = Place::new();
    place.block("rest.toml", "");
    let done = place.runner(&["rest.toml", "--set", "duration=0.1"]).exits(0);
    assert!(done.stdout.starts_with("scenario"), "{}", done.stdout);
    assert!(!done.stdout.contains("[1/1]") && done.stderr.contains("[1/1] rest: passed"), "{}", done.stderr);
    assert!(!done.stdout.contains('\u{1b}') && !done.stderr.contains('\u{1b}'), "no colours in a pipe");
}

#[test]
fn an_unwritable_output_is_an_error_before_the_first_run() {
    let place = Place::new();
    place.block("long.toml", "").write("file", "in the way");
    for output in ["file", "file/below"] {
        // This run would practically never end.
        let done = place.runner(&["long.toml", "--set", "duration=1e9", "-o", output]).exits(2);
        assert!(done.stderr.contains("cannot write results into file"), "{}", done.stderr);
    }
}

#[test]
fn keys_depend_on_content_not_on_paths() {
    let first = Place::new();
    first.block("s.toml", "");
    let key = |place: &Place, arguments: &[&str]| {
        let all: Vec<&str> = ["list", "--format", "csv"].iter().chain(arguments).copied().collect();
        Table::parse(&place.runner(&all).exits(0).stdout).column("key")[0].to_owned()
    };
    let original = key(&first, &["s.toml"]);
    // Another folder, another name and another path to the robot.
    let second = Place::new();
    for name in ["block.toml", "block.urdf"] {
        second.write(&format!("elsewhere/{name}"), fs::read(first.path("block").join(name)).unwrap());
    }
    second.write("deep/t.toml", "[robot]\nmodel = \"../elsewhere/block.toml\"\n");
    assert_eq!(key(&second, &["deep/t.toml"]), original);
    let absolute = second.path("deep/t.toml");
    assert_eq!(key(&first, &[absolute.to_str().unwrap()]), original);
    // Every change of a run changes its key: a value, the seed, the robot's bytes.
    let mut keys = vec![original];
    keys.push(key(&first, &["s.toml", "--set", "duration=1"]));
    keys.push(key(&first, &["s.toml", "--set", "seed=2"]));
    let urdf = fs::read_to_string(first.path("block/block.urdf")).unwrap();
    first.write("block/block.urdf", urdf.replace("0.76 0.60 0.42 1", "1 0 0 1"));
    keys.push(key(&first, &["s.toml"]));
    let mut distinct = keys.clone();
    distinct.sort();
    distinct.dedup();
    assert_eq!(distinct.len(), keys.len(), "{keys:?}");
}

#[test]
fn contact_problems_are_written_on_request() {
    let place = Place::new();
    // Three corners start below the floor and one above it. No state clamps exactly these three.
    // The direct search would leave the choice to velocity-level steps.
    place.block(
        "s.toml",
        "contact = \"soles\"\n[robot.base]\nposition = [0, 0, 0.049]\nrpy = [0.01, 0.02, 0]\n[contact]\nexact.search = \"paper\"\n[stop]\nsunk_link = \"ignore\"\n",
    );
    let folder = |results: &str| {
        let key = place.summary(results).column("key")[0].to_owned();
        place.path(results).join("s").join(key).join("problems")
    };
    let set = ["s.toml", "--set", "duration=0.2", "--no-log", "-o"];
    let run = |results: &str, more: &[&str]| place.runner(&[&set[..], &[results, "-v"], more].concat()).exits(0);

    run("plain", &[]);
    assert!(!folder("plain").exists());

    let done = run("some", &["--dump-problems"]);
    let inconsistent = place.summary("some").numbers("inconsistent")[0] as usize;
    assert!(inconsistent > 0);
    assert_eq!(fs::read_dir(folder("some")).unwrap().count(), inconsistent.min(100));
    assert!(done.stdout.contains("/problems\n"), "{}", done.stdout);
    let problem = ProblemRecord::read(&folder("some").join("0001.json")).unwrap();
    assert_eq!(problem.scenario, "s");
    assert_eq!(problem.selection.soles[0].name, "bottom");

    // 200 steps with one selection each.
    let fixed = ["--dump-problems=all", "--set", "integrator.method=semi-implicit", "--set", "integrator.step=1e-3"];
    let done = run("all", &fixed);
    assert_eq!(fs::read_dir(folder("all")).unwrap().count(), 100);
    assert!(done.stdout.contains(": the first 100 of 201 selections are written, 101 more are not"), "{}", done.stdout);

    let refused = place.runner(&["s.toml", "--dump-problems=some"]).exits(2);
    assert!(refused.stderr.contains("[possible values: inconsistent, all]"), "{}", refused.stderr);
}

#[test]
fn verdicts_are_printed_and_recorded() {
    let place = Place::new();
    place.block(
        "rest.toml",
        "[[expect]]\nmetric = \"final_base_z\"\nvalue = 0.05\nrelative_tolerance = 1e-9\n[[expect]]\nmetric = \"jams\"\nmax = 0\n[sweep]\nzip = [{ duration = [0.1, 0.2], \"expect.0.value\" = [0.05, 0.07] }]\n",
    );
    let verdict_lines = |which: &[&str]| -> Vec<String> {
        let arguments: Vec<&str> = ["rest.toml"].iter().chain(which).copied().collect();
        let done = place.runner(&arguments).exits(1);
        let lines = done.stdout.lines().skip_while(|l| !l.contains("measured")).skip(1);
        lines.take_while(|l| !l.contains("expectations held")).map(str::to_owned).collect()
    };
    // 0.05 is right and 0.07 is wrong. The limits hold.
    let values = verdict_lines(&["--verdicts", "values"]);
    assert_eq!(values, verdict_lines(&["--verbose"]));
    assert_eq!(values.len(), 4, "two runs with a line each: {values:?}");
    assert!(values[0] == "rest duration=0.1" && values[1].ends_with("yes"), "{values:?}");
    assert!(values[3].contains("0.07  -2.0e-2    2.9e-1") && values[3].ends_with("NO"), "{values:?}");
    assert_eq!(verdict_lines(&["--verdicts", "failed"]).len(), 2);
    assert_eq!(verdict_lines(&["--verdicts", "all"]).len(), 6);
    let done = place.runner(&["rest.toml"]).exits(1);
    let failed: Vec<&str> = done.stdout.lines().filter(|line| line.starts_with("failed rest ")).collect();
    assert!(failed.len() == 1 && failed[0].contains("(duration=0.2): final_base_z is 0.05"), "{}", done.stdout);
    assert!(!done.stdout.contains("measured"), "no table: {}", done.stdout);
    let (summary, log) = (place.summary("results"), fs::read_to_string(place.path("results/runs.jsonl")).unwrap());
    let lines: Vec<serde_json::Value> = log.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    for (key, held) in summary.column("key").into_iter().zip([true, false]) {
        let record = RunRecord::read(&place.path("results/rest").join(key).join("run.json")).unwrap();
        assert_eq!(record.verdicts.iter().map(|v| v.held).collect::<Vec<_>>(), [held, true]);
        let line = lines.iter().find(|l| l["key"] == key).unwrap();
        assert_eq!(line["verdicts"][0]["held"], held);
        assert_eq!(line["verdicts"][0]["truth"], record.verdicts[0].truth.unwrap());
    }
}
