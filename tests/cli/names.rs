//! Tests of scenario names with control characters: escaped in text, unchanged in machine-readable
//! output.

#![cfg(unix)]

use super::{Done, Place};

const NAMES: [&str; 2] = ["e\u{1b}[31mred\u{9b}", "two\nlines"];
const ESCAPED: [&str; 2] = ["e\\u{1b}[31mred\\u{9b}", "two\\nlines"];

/// Asserts that control characters other than line breaks are escaped, and that no name starts a
/// line.
#[track_caller]
fn assert_escaped(text: &str) {
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "{text:?}");
    assert!(!text.lines().any(|line| line.starts_with("lines")), "{text:?}");
    ESCAPED.iter().for_each(|name| assert!(text.contains(name), "{text:?}"));
}

fn scenarios(text: &str) -> (Place, [String; 2]) {
    let place = Place::new();
    let files = NAMES.map(|name| format!("{name}.toml"));
    files.iter().for_each(|file| _ = place.block(file, text));
    (place, files)
}

#[test]
fn control_characters_in_names_are_escaped_in_text_only() {
    let (place, [a, b]) = scenarios("[[expect]]\nmetric = \"duration_s\"\nmax = 0.001\n");
    let duration = ["--set", "duration=0.01"];
    let run = |more: &[&str], code| place.runner(&[&[a.as_str(), &b][..], &duration, more].concat()).exits(code);
    let Done { stdout, stderr, .. } = run(&["--slow", "1e-9", "--junit", "junit.xml", "-v"], 1);
    assert_escaped(&stdout);
    assert_escaped(&stderr);
    for text in ["failed e\\u", "slow: e\\u", "failed two\\n", "slow: two\\n", "  results/two\\nlines/"] {
        assert!(stdout.contains(text), "{text}: {stdout}");
    }
    assert_escaped(&place.runner(&["list", &a, &b]).exits(0).stdout);
    assert_escaped(&place.runner(&["check", &a, &b]).exits(0).stdout);
    assert_escaped(&place.runner(&["replay", "results"]).exits(0).stdout);
    assert_escaped(
        &run(&["--max-runs", "1"], 2).stderr.replace("two\\nlines.toml", "e\\u{1b}[31mred\\u{9b} two\\nlines"),
    );

    // Machine-readable output has the unchanged names.
    let listed: serde_json::Value =
        serde_json::from_str(&place.runner(&["list", &a, &b, "--format", "json"]).exits(0).stdout).unwrap();
    assert_eq!([&listed[0]["scenario"], &listed[1]["scenario"]], NAMES);
    assert!(place.runner(&["list", &a, "--format", "csv"]).exits(0).stdout.contains(NAMES[0]));
    assert!(std::fs::read_to_string(place.path("results/summary.csv")).unwrap().contains(NAMES[0]));
    let messages = run(&["--message-format", "json", "-o", "again"], 1).stdout;
    let messages: Vec<serde_json::Value> = messages.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(NAMES.iter().all(|name| messages.iter().any(|line| line["scenario"] == *name)), "{messages:?}");
}

#[test]
fn errors_in_files_with_such_names_are_escaped() {
    let (place, [a, b]) = scenarios("[floor]\nfrction = 1\n");
    let stderr = place.runner(&["check", &a, &b]).exits(2).stderr;
    assert_escaped(&stderr);
    assert!(stderr.contains("two\\nlines.toml:4:1"), "{stderr}");
    assert_escaped(&place.runner(&["check", &format!("{a}x"), &format!("{b}x")]).exits(2).stderr);
    let stderr = place.runner(&["merge", &a, &b, "-o", "merged"]).exits(2).stderr;
    assert!(!stderr.contains('\u{1b}'), "{stderr:?}");
}

#[test]
fn control_characters_of_foreign_results_do_not_reach_the_terminal() {
    let place = Place::new();
    let row =
        |outcome: &str| format!("{{\"scenario\":\"s\",\"key\":\"k\",\"outcome\":\"{outcome}\",\"c\\u001b[2J\":1}}\n");
    place.write("a.jsonl", row("passed")).write("b.jsonl", row("f\\u001b]0;title\\u0007"));
    let done = place.runner(&["compare", "a.jsonl", "b.jsonl"]).exits(1);
    assert!(done.stdout.contains("f\\u{1b}]0;title\\u{7}"), "{}", done.stdout);
    let control = |text: &str| text.chars().any(|c| c.is_control() && c != '\n');
    assert!(!control(&done.stdout) && !control(&done.stderr), "{:?}", done.stdout);
}
