//! Equal runs give equal bits, whichever runs are in the batch, in any order, in one batch or in
//! parts. The tests compare all result files except for times: rows, records, lines of
//! `runs.jsonl`, and logs byte by byte, including the order of events. `faults/` tests the results
//! of interrupted batches.
//!
//! The scenes are randomized: poses, speeds and pushes are drawn, so that no symmetry makes an
//! order of sums or of events irrelevant.

mod golden_hashes;
mod log_rates;
mod merge_faults;
mod shards;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::cli::{Place, Table};
use crate::support::same::{assert_same, files, rows};

/// Thrown blocks that tumble, slide and stick, with all methods that can land: impacts and changes
/// of state in every run.
const THROWN: &str = "base = { position = [0, 0, 0.3], rpy = [0.3, 0.2, 0.1], linear_velocity = [1, 0.3, 0] }
[sweep.grid]
\"contact.method\" = [\"exact\", \"one-step\"]
[sweep.random]
samples = 4
\"robot.base.rpy.0\" = { uniform = [0.1, 0.5] }
\"robot.base.rpy.1\" = { uniform = [-0.3, 0.3] }
\"robot.base.linear_velocity.1\" = { uniform = [-0.5, 0.5] }
\"floor.friction\" = { uniform = [0.2, 0.8] }
";

/// A humanoid that is pushed while it stands, with stiff joints between its soles.
const PUSHED: &str = "[[force]]
type = \"push\"
link = \"torso\"
force = [20, 5, 0]
start = 0.05
duration = 0.1
profile = \"half-sine\"
[sweep.grid]
\"contact.method\" = [\"exact\", \"one-step\"]
[sweep.random]
samples = 2
\"force.0.force.0\" = { uniform = [10, 30] }
\"force.0.force.1\" = { uniform = [-10, 10] }
";

/// A quadruped on four point feet that slides down a slope and turns.
const SLIDES: &str = "base = { rpy = [0, \"15 deg\", 0], linear_velocity = [0, 0.1, 0] }
[floor]
friction = 0.2
rpy = [0, \"15 deg\", 0]
[sweep.random]
samples = 2
\"robot.base.linear_velocity.1\" = { uniform = [-0.3, 0.3] }
";

/// Sliding blocks compared with runs at a tighter tolerance; runs of two methods share a reference.
const COMPARED: &str = "base = { linear_velocity = [1, 0, 0] }
[compare]
reference = { \"contact.method\" = \"exact\", \"integrator.method\" = \"dopri5\", \"integrator.relative_tolerance\" = 1e-9 }
[sweep.grid]
\"integrator.method\" = [\"dopri5\", \"bs23\"]
[sweep.random]
samples = 3
\"robot.base.linear_velocity.1\" = { uniform = [-1, 1] }
";

const FILES: [&str; 5] = ["thrown.toml", "pushed.toml", "rest.toml", "slides.toml", "compared.toml"];

/// All scenarios; none repeats seeds: 8 + 4 + 1 + 2 + 6 runs and 3 references.
fn scenarios() -> Place {
    let place = Place::new();
    place.block("thrown.toml", THROWN);
    place.block("rest.toml", "");
    place.block("compared.toml", COMPARED);
    let robot = |name: &str| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("robots/{name}/{name}.toml"));
    place.write("pushed.toml", format!("[robot]\nmodel = {:?}\n{PUSHED}", robot("hoap2")));
    place.write("slides.toml", format!("[robot]\nmodel = {:?}\n{SLIDES}", robot("quadruped")));
    place
}

const RUNS: usize = 8 + 4 + 1 + 2 + 6;
const REFERENCES: usize = 3;

#[track_caller]
fn run(place: &Place, files: &[&str], more: &[&str]) {
    let done = place.runner(&[files, &["--set", "duration=0.4"], more].concat());
    // Other tests check how the runs end; here equal ends are enough.
    assert!(matches!(done.code, Some(0 | 1 | 3)), "{}", done.stderr);
}

#[test]
fn one_two_and_seven_threads_give_the_same_bits() {
    let place = scenarios();
    for jobs in ["1", "2", "7"] {
        run(&place, &FILES, &["-j", jobs, "-o", jobs]);
    }
    let one = place.path("1");
    let logs = files(&one).into_iter().filter(|file| file.ends_with("log.mcap")).count();
    let records = files(&one).into_iter().filter(|file| file.ends_with("run.json")).count();
    assert_eq!((logs, records), (RUNS, RUNS + REFERENCES));
    for jobs in ["2", "7"] {
        assert_same(&one, &place.path(jobs));
    }
    let table = place.summary("1");
    for column in ["state_changes", "impacts", "evaluations"] {
        let total: f64 = table.numbers(column).iter().sum();
        assert!(total > 0.0, "something must happen in runs that are compared: {column}");
    }
    let mut ends = table.column("final_base_x");
    ends.sort_unstable();
    ends.dedup();
    // Two integrators may agree to the last bit on a sliding block.
    assert!(ends.len() >= RUNS - REFERENCES, "the scenes are different ones: {ends:?}");
}

/// Result files and the sorted rows: the parts that must not depend on the order of the batch.
fn order_independent(results: &Path) -> (Vec<String>, Vec<Vec<(String, String)>>) {
    let mut sorted = rows(&Table::read(&results.join("summary.csv")));
    // A batch has columns for the parameters of all its scenarios.
    sorted.iter_mut().for_each(|row| row.sort());
    sorted.sort();
    (files(results), sorted)
}

#[test]
fn results_do_not_depend_on_the_order_or_the_other_runs() {
    let place = scenarios();
    run(&place, &FILES, &["-o", "all"]);
    let orders = [["rest.toml", "compared.toml", "slides.toml", "thrown.toml", "pushed.toml"], {
        let mut reversed = FILES;
        reversed.reverse();
        reversed
    }];
    for (i, order) in orders.iter().enumerate() {
        let output = format!("order-{i}");
        run(&place, order, &["-j", "2", "-o", &output]);
        assert_eq!(order_independent(&place.path("all")), order_independent(&place.path(&output)));
    }
    // Each file alone, and one run alone.
    let mut logs = BTreeMap::new();
    for file in FILES {
        run(&place, &[file], &["-j", "1", "-o", "alone"]);
    }
    for file in files(&place.path("all")).into_iter().filter(|file| file.ends_with("log.mcap")) {
        let (all, alone) = (fs::read(place.path("all").join(&file)).unwrap(), place.path("alone").join(&file));
        assert!(all == fs::read(alone).unwrap(), "{file}");
        logs.insert(file, all);
    }
    assert_eq!(logs.len(), RUNS);
    let alone = ["--set", "contact.method=exact", "--set", "robot.base.linear_velocity.1=0.25"];
    run(&place, &["compared.toml"], &[&alone[..], &["--set", "integrator.method=bs23", "-o", "one"]].concat());
    run(&place, &["compared.toml"], &[&alone[..], &["-o", "two"]].concat());
    let (one, two) = (place.summary("one"), place.summary("two"));
    let comparable = |table: &Table| -> Vec<Vec<(String, String)>> {
        // The method is no longer swept.
        let rows = rows(table).into_iter();
        rows.map(|row| row.into_iter().filter(|(name, _)| name != "integrator.method").collect()).collect()
    };
    assert_eq!((one.rows.len(), two.rows.len()), (1, 2));
    assert!(comparable(&two).contains(&comparable(&one)[0]));
}
