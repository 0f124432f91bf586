//! The same run gives the same bits, however many run beside it and in whatever order. Compared are the rows of the
//! summary but for the timings, and the logs byte by byte.

use std::fs;
use std::path::PathBuf;

use crate::cli::{Place, Table};

/// What may differ between two equal runs.
const TIMINGS: [&str; 3] = ["wall_s", "cpu_s", "real_time_factor"];

/// Blocks that are thrown, tumble, slide and stick, by two methods: impacts and changes of state in every run.
const THROWN: &str = "base = { position = [0, 0, 0.3], rpy = [0.3, 0.2, 0.1], linear_velocity = [1, 0.3, 0] }
[sweep.grid]
\"contact.method\" = [\"exact\", \"one-step\"]
\"floor.friction\" = [0.2, 0.5, 0.8]
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
";

fn scenarios() -> Place {
    let place = Place::new();
    place.block("thrown.toml", THROWN);
    place.block("rest.toml", "");
    let hoap2 = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/hoap2/hoap2.toml");
    place.write("pushed.toml", format!("[robot]\nmodel = {hoap2:?}\n{PUSHED}"));
    place
}

/// Rows without timings, by scenario and key.
fn rows(table: &Table) -> Vec<Vec<(String, String)>> {
    let row = |cells: &Vec<String>| {
        let named = table.header.iter().cloned().zip(cells.iter().cloned());
        named.filter(|(name, _)| !TIMINGS.contains(&name.as_str())).collect()
    };
    table.rows.iter().map(row).collect()
}

fn logs(place: &Place, results: &str) -> Vec<PathBuf> {
    let table = place.summary(results);
    let folder = |(scenario, key)| place.path(results).join(scenario).join(key).join("log.mcap");
    table.column("scenario").into_iter().zip(table.column("key")).map(folder).collect()
}

#[test]
fn one_and_two_threads_give_the_same_rows_and_logs() {
    let place = scenarios();
    let run = |jobs, output| {
        let files = ["thrown.toml", "rest.toml", "pushed.toml"];
        let arguments = [&files[..], &["--set", "duration=0.6", "-j", jobs, "-o", output]].concat();
        let done = place.runner(&arguments);
        // How the runs end is for other tests; here it is enough that they end alike.
        assert!(matches!(done.code, Some(0 | 3)), "{}", done.stderr);
    };
    run("1", "one");
    run("2", "two");
    let (one, two) = (place.summary("one"), place.summary("two"));
    assert_eq!(one.rows.len(), 9);
    assert_eq!(one.header, two.header);
    assert_eq!(rows(&one), rows(&two));
    for (a, b) in logs(&place, "one").iter().zip(logs(&place, "two")) {
        let (a, b) = (fs::read(a).unwrap(), fs::read(b).unwrap());
        assert!(a.len() > 1000 && a == b, "logs of {} and {} bytes differ", a.len(), b.len());
    }
    let states: f64 = one.numbers("state_changes").iter().sum();
    assert!(states > 0.0, "something must happen in runs that are compared");
}

#[test]
fn order_and_company_change_nothing() {
    let place = scenarios();
    place.runner(&["thrown.toml", "rest.toml", "--set", "duration=0.5", "-o", "both", "--no-log"]);
    place.runner(&["rest.toml", "thrown.toml", "--set", "duration=0.5", "-o", "turned", "--no-log", "-j", "1"]);
    let alone =
        ["thrown.toml", "--set", "duration=0.5", "--set", "contact.method=exact", "--set", "floor.friction=0.5"];
    place.runner(&[&alone[..], &["-o", "alone", "--no-log"]].concat());
    let by_key = |results| {
        let mut rows = rows(&place.summary(results));
        rows.sort();
        rows
    };
    assert_eq!(by_key("both"), by_key("turned"));
    let alone = by_key("alone");
    assert_eq!(alone.len(), 1);
    assert!(by_key("both").contains(&alone[0]), "{alone:?}");
}
