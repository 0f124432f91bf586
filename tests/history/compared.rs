//! Comparisons of many results with a baseline, and trends in a history.

use std::fs;

use serde_json::{Value, json};

use super::{Row, table};
use crate::cli::Place;

/// Appends a result and returns the comparison with those before it.
fn append(place: &Place, label: &str, more: &[&str], code: i32) -> Value {
    let arguments = ["compare", "--baseline", "h", "--append", "--format", "json", "r.csv", "--label", label];
    let done = place.runner(&[&arguments, more].concat()).exits(code);
    serde_json::from_str(&done.stdout).unwrap()
}

/// The series of a column of the only run.
fn series<'a>(compared: &'a Value, column: &str) -> &'a Value {
    let all = compared["results"][0]["history"]["series"].as_array().unwrap();
    all.iter().find(|own| own["column"] == column).unwrap_or_else(|| panic!("{column}: {compared}"))
}

#[test]
fn many_results_are_compared_with_one_baseline() {
    let place = Place::new();
    let rows = |x: f64| [Row("0.5", 10, x, 1.0), Row("0.6", 20, 0.5, 1.0)];
    table(&place, "a.csv", "v", &rows(0.25));
    table(&place, "same.csv", "w", &rows(0.25));
    table(&place, "other/summary.csv", "w", &rows(0.375));
    table(&place, "less.csv", "w", &rows(0.75)[..1]);
    let done = place.runner(&["compare", "--baseline", "a.csv", "same.csv", "other", "less.csv"]).exits(1);
    let table_of = |text: &str| text.split("\nverdict ").nth(1).unwrap_or_default().to_owned();
    let lines: Vec<Vec<String>> = table_of(&done.stdout)
        .lines()
        .skip(1)
        .take(3)
        .map(|line| line.split_whitespace().map(str::to_owned).collect())
        .collect();
    let line = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(
        lines,
        [
            line("within same.csv 2 0 0 0 - 0"),
            line("different other/summary.csv 2 1 0 0 - 0"),
            line("different less.csv 1 1 0 1 - 0")
        ],
        "{}",
        done.stdout
    );
    assert!(done.stdout.ends_with("3 results compared: 1 within the tolerances\n"), "{}", done.stdout);
    // Each is compared as two results are.
    let pair = place.runner(&["compare", "a.csv", "other"]).exits(1).stdout;
    assert!(done.stdout.contains(&pair), "{pair}\n{}", done.stdout);
    let all =
        place.runner(&["compare", "--baseline", "a.csv", "other", "less.csv", "--format", "json"]).exits(1).stdout;
    let all: Value = serde_json::from_str(&all).unwrap();
    let pair = place.runner(&["compare", "a.csv", "other", "--format", "json"]).exits(1).stdout;
    assert_eq!(all["results"][0]["changes"], serde_json::from_str::<Value>(&pair).unwrap());
    let columns = json!([{ "column": "final_base_x", "results": 2, "beyond": 2, "greatest": 0.5 }]);
    assert_eq!(all["overview"]["columns"], columns);
    place.runner(&["compare", "--baseline", "a.csv", "same.csv", "a.csv"]).exits(0);
    place.write("empty.jsonl", "");
    place.runner(&["compare", "--baseline", "empty.jsonl", "empty.jsonl"]).exits(4);
}

/// A change of each kind, in all fields.
#[test]
fn the_object_has_its_fields() {
    let place = Place::new();
    table(&place, "r.csv", "a", &[Row("0.5", 10, 0.25, 1.0), Row("0.6", 20, 0.5, 1.0)]);
    append(&place, "v1", &[], 0);
    table(&place, "r.csv", "b", &[Row("0.5", 10, 0.25, 3.0), Row("0.6", 21, 0.5, 1.0)]);
    append(&place, "v2", &[], 1);
    table(&place, "r.csv", "c", &[Row("0.5", 10, 0.75, 2.0), Row("0.6", 21, 0.5, 1.0)]);
    let done = place.runner(&["compare", "--baseline", "h", "--format", "json", "--timing", "4", "r.csv"]).exits(1);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/history/compared.json");
    if std::env::var_os("STICTION_GOLDEN").is_some_and(|value| value == "renew") {
        fs::write(path, &done.stdout).unwrap();
    }
    assert_eq!(done.stdout, fs::read_to_string(path).unwrap());
}

#[test]
fn statistics_are_those_of_the_last_values() {
    let place = Place::new();
    for (i, x) in [100.0, 1.0, 2.0, 4.0, 8.0].into_iter().enumerate() {
        table(&place, "r.csv", &format!("v{i}"), &[Row("0.5", 7, x, 1.0)]);
        append(&place, &format!("v{i}"), &[], i32::from(i > 0));
    }
    table(&place, "r.csv", "w", &[Row("0.5", 7, 8.5, 1.0)]);
    let compared = append(&place, "w", &["--last", "4", "--threshold", "final_base_x=1"], 0);
    let found = series(&compared, "final_base_x");
    let expected = json!([8.5, 8.0, 3.0, 7.0, 4, false]);
    let fields = ["value", "last", "median", "spread", "values", "is_changed"].map(|name| found[name].clone());
    assert_eq!(Value::from(fields.to_vec()), expected);
    let history = &compared["results"][0]["history"];
    // Duration, steps; position varies. Times are left out.
    assert_eq!((&history["constant"], &history["tested"], &history["results"]), (&2.into(), &1.into(), &5.into()));
    // Five rising values: 2 / 5!.
    assert_eq!((&found["trend"]["s"], &found["trend"]["is_shown"]), (&10.into(), &false.into()));
    assert!((found["trend"]["p"].as_f64().unwrap() - 2.0 / 120.0).abs() < 1e-15, "{found}");
}

/// Steps within the tolerance, whose sum is beyond it.
#[test]
fn a_slow_drift_is_a_trend_and_noise_is_none() {
    let place = Place::new();
    let noise = [0.3, 0.1, 0.4, 0.15, 0.9, 0.26, 0.5, 0.35, 0.8];
    let mut last = Value::Null;
    for (i, wall) in noise.into_iter().enumerate() {
        let x = 1.0 + 4e-7 * i as f64;
        table(&place, "r.csv", &format!("v{i}"), &[Row("0.5", 7, x, wall)]);
        // 2 / 6! < 0.01 < 2 / 5!, and 5 steps of 4e-7 are more than 1e-6.
        last = append(&place, &format!("v{i}"), &[], i32::from(i >= 5));
    }
    let result = &last["results"][0];
    assert_eq!(result["changes"]["beyond"], json!([]), "no step is a change");
    assert_eq!((&result["is_within"], &result["history"]["trends"]), (&false.into(), &1.into()));
    assert_eq!(series(&last, "final_base_x")["trend"]["is_shown"], true);
    // With times: the noise is no trend; a slowdown is one, though each step is within the ratio.
    table(&place, "r.csv", "n", &[Row("0.5", 7, 1.0, 0.45)]);
    let timed = append(&place, "n", &["--timing", "20", "--threshold", "final_base_x=1"], 0);
    assert_eq!(series(&timed, "wall_s")["trend"]["is_shown"], false);
    let place = Place::new();
    for i in 0..8 {
        table(&place, "r.csv", &format!("v{i}"), &[Row("0.5", 7, 1.0, 1.0 + 0.01 * f64::from(i))]);
        append(&place, &format!("v{i}"), &["--timing", "1.5"], i32::from(i >= 5));
    }
    table(&place, "r.csv", "w", &[Row("0.5", 7, 1.0, 2.0)]);
    append(&place, "w", &[], 0);
    let text = place.runner(&["compare", "--baseline", "h", "r.csv", "--timing", "3"]).exits(1).stdout;
    assert!(text.contains("1 trend at the level 0.01 of 1 test"), "{text}");
    assert!(text.lines().any(|line| line.starts_with("wall_s") && line.ends_with("rises")), "{text}");
}

#[test]
fn a_history_is_compared_by_scenario_with_its_newest_result() {
    let place = Place::new();
    let other = |scenario: &str, x: f64| {
        table(&place, "r.csv", "v", &[Row("0.5", 7, x, 1.0)]);
        let text = fs::read_to_string(place.path("r.csv")).unwrap().replace("\ns,", &format!("\n{scenario},"));
        place.write("r.csv", text);
    };
    other("s", 1.0);
    append(&place, "v1", &[], 0);
    // A scenario that the history does not have: a run of only one of them.
    other("t", 2.0);
    let compared = append(&place, "v1", &[], 1);
    assert_eq!(compared["results"][0]["changes"]["only_in_b"], json!(["t mu=0.5"]));
    // Each of them alone, later.
    other("s", 1.0 + 1e-8);
    append(&place, "v2", &[], 0);
    other("t", 2.0 + 1e-8);
    append(&place, "v2", &[], 0);
    // A folder with results stands for them, not for its history.
    fs::copy(place.path("r.csv"), place.path("h/summary.csv")).unwrap();
    let done = place.runner(&["compare", "--baseline", "h", "r.csv"]).exits(0);
    assert!(done.stdout.starts_with("A: h/summary.csv\n"), "{}", done.stdout);
    let done = place.runner(&["compare", "--baseline", "h/history.parquet", "r.csv"]).exits(0);
    assert!(done.stdout.contains("3 results in the history"), "without itself: {}", done.stdout);
    let done = place.runner(&["compare", "r.csv", "h/history.parquet"]).exits(2);
    assert!(done.stderr.contains("a history of results: give it as --baseline"), "{}", done.stderr);
}
