//! Results of a small batch of a sliding block: valid files that are mutated, and the surroundings
//! of a fuzzed file.

use std::path::{Path, PathBuf};

use stiction::compare::Results;
use stiction::files::names;
use stiction::history::{KEPT_RESULTS, append};
use stiction::results::claims::{ClaimHead, GroupHead, RunClaim};
use stiction::scenario::{ClaimSpec, Expect, ExpectedOutcome};
use stiction::{Options, run_batch};

use super::{scratch, tree};

/// Two runs with logs, expectations, parameters, a reference run and events.
const SCENARIO: &str = r#"
duration = 0.02
[robot]
model = "MODEL"
base = { position = [0, 0, 0.05], linear_velocity = [1, 0, 0] }
[log]
rate = 500
[compare]
reference = { "integrator.relative_tolerance" = 1e-7 }
[[expect]]
metric = "final_base_x"
min = 0.0
max = 0.001
[[event]]
at = 0.01
set = { "floor.friction" = 0.2 }
[sweep.grid]
"contact.method" = ["exact", "one-step"]
"#;

thread_local! {
    static RESULTS: PathBuf = batch();
}

fn batch() -> PathBuf {
    let folder = scratch::folder("samples");
    let model = tree::root().join("robots/block/block.toml");
    let scenario = folder.join("slide.toml");
    scratch::write(&scenario, SCENARIO.replace("MODEL", model.to_str().expect("UTF-8")).as_bytes());
    let output = folder.join("results");
    let options = Options { output: output.clone(), jobs: 1, ..Options::default() };
    let report = run_batch([&scenario], options).expect("a sound batch");
    assert_eq!(report.statistics.runs(), 2);
    output
}

/// Folder of the results.
pub fn results() -> PathBuf {
    RESULTS.with(PathBuf::clone)
}

/// A history with other results of the same runs.
pub fn history() -> Vec<u8> {
    let folder = scratch::empty_folder("sample-history");
    let (path, summary) = (folder.join(names::HISTORY), folder.join(names::SUMMARY_CSV));
    let rows = text(&results().join(names::SUMMARY_CSV)).replace(",passed,", ",fallen,");
    scratch::write(&summary, rows.as_bytes());
    let mut results = Results::open(&summary).expect("results");
    append(&path, &mut results, Some("first"), KEPT_RESULTS.get()).expect("a new history");
    std::fs::read(path).expect("a history")
}

/// Folder of a run.
pub fn run() -> PathBuf {
    let runs = std::fs::read_dir(results().join("slide")).expect("results");
    let mut folders: Vec<_> = runs.map(|run| run.expect("a run").path()).collect();
    folders.retain(|path| path.file_name().is_some_and(|name| name != names::REFERENCES));
    folders.sort();
    folders.remove(0)
}

/// Its log.
pub fn log() -> PathBuf {
    run().join(names::LOG)
}

/// Its record without the checksum: a mutated record would otherwise only be refused for that.
pub fn record() -> String {
    without_checksum(&text(&run().join(names::RUN_RECORD)))
}

/// `runs.jsonl` without checksums.
pub fn runs_log() -> String {
    text(&results().join(names::RUNS_LOG)).lines().map(|line| without_checksum(line) + "\n").collect()
}

/// `claims.json` with a claim of two runs.
pub const CLAIMS: &str = r#"{"schema": 1, "program": "stiction 0.1.0", "claims": [{
  "scenario": "slide", "claim": "slow", "group": "contact.method=exact", "statement": "0.5 quantile of impacts at most 1",
  "verdict": "undecided", "estimate": 0.5, "lower": null, "upper": "inf", "limit": 1.0, "at_least": false,
  "confidence": 0.95, "early": false, "paired": false, "used": 2, "planned": 3, "without_value": 1, "threshold": 0.5,
  "trace": [{"units": 1, "share": 1.0, "lower": 0.05, "upper": 1.0},
            {"units": 2, "share": 0.5, "lower": 0.02532, "upper": 0.97468}]}]}
"#;

/// `searches.json` with a search of each kind.
pub const SEARCHES: &str = r#"{"schema": 1, "program": "stiction 0.1.0", "searches": [{
  "scenario": "slide", "search": "boundary", "subject": "outcome fallen", "keys": ["duration"], "logarithmic": [false], "cell": 0,
  "label": "contact.method=exact", "parameters": {"contact.method": "exact"}, "verdict": "not-monotone", "message": "",
  "interval": {"lower": 1.0, "upper": 1.5, "holds_above": true, "changes": [[1.0, 1.5], [2.0, 3.0]]}, "best": null, "runs": 2,
  "probes": [{"at": [1.0], "run": "0123456789abcdef", "outcome": "passed", "holds": false},
             {"at": [1.5], "run": "0123456789abcdee", "outcome": "fallen", "holds": true}]}, {
  "scenario": "slide", "search": "boundary", "subject": "impacts at most 3", "keys": ["duration", "floor.height"], "logarithmic": [true, false], "cell": 0,
  "label": "", "parameters": {}, "verdict": "found", "message": "", "interval": null, "best": null, "runs": 2,
  "lines": [[{"lower": [1.0, 0.5], "upper": [1.5, 0.5], "holds_above": true},
             {"lower": [1.0, 0.75], "upper": [1.0, 1.0], "holds_above": false}]],
  "probes": [{"at": [1.0, 0.5], "run": "0123456789abcdef", "outcome": "passed", "holds": false},
             {"at": [1.5, 0.5], "run": "0123456789abcdee", "outcome": "error"}]}, {
  "scenario": "slide", "search": "minimum", "subject": "impacts", "keys": ["duration"], "logarithmic": [false], "cell": 0, "label": "",
  "parameters": {}, "verdict": "found", "message": "", "interval": null,
  "best": {"at": [1.5], "value": 2.0, "run": "0123456789abcdee"}, "runs": 2,
  "probes": [{"at": [1.0], "run": "0123456789abcdef", "outcome": "passed", "value": 3.0},
             {"at": [1.5], "run": "0123456789abcdee", "outcome": "passed", "value": 2.0}]}]}
"#;

/// `shard.jsonl` of a plan of these runs.
pub fn shard_list() -> String {
    let key = run().file_name().expect("a name").to_string_lossy().into_owned();
    let files = [("slide: block.urdf".to_owned(), "0123456789abcdef".to_owned())].into();
    let groups = vec![GroupHead { label: String::new(), planned: 2 }];
    let share = Expect { outcome: Some(ExpectedOutcome::Passed), ..Expect::default() };
    let claim = ClaimSpec { name: "c".into(), share: Some(share), at_least: Some(0.5), ..ClaimSpec::default() };
    let head = stiction::results::ShardHead::new(1, 2, 2, "0123456789abcdef".into(), files);
    let head =
        stiction::results::ShardHead { claims: vec![ClaimHead { scenario: "slide".into(), claim, groups }], ..head };
    let part = RunClaim { claim: 0, group: 0, unit: 0, side: 0 };
    let run = stiction::results::ShardRun {
        at: 0,
        scenario: "slide".into(),
        key,
        levels: Default::default(),
        claims: vec![part],
    };
    let line = |text: serde_json::Result<String>| text.expect("JSON") + "\n";
    line(serde_json::to_string(&head)) + &line(serde_json::to_string(&run))
}

/// The text of a file.
pub fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn without_checksum(object: &str) -> String {
    match object.rfind(",\"checksum\"").or_else(|| object.rfind(",\n  \"checksum\"")) {
        Some(at) => object[..at].to_owned() + if object[at..].contains('\n') { "\n}\n" } else { "}" },
        None => object.to_owned(),
    }
}
