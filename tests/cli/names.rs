//! Names of scenarios with characters that a terminal would obey: shown to people, whole for programs.

#![cfg(unix)]

use super::{Done, Place};

const NAMES: [&str; 2] = ["e\u{1b}[31mred\u{9b}", "two\nlines"];
const SHOWN: [&str; 2] = ["e\\u{1b}[31mred\\u{9b}", "two\\nlines"];

/// Is nothing there that a terminal would obey, but line breaks, and does every one of these lines begin so?
#[track_caller]
fn is_shown(text: &str) {
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "{text:?}");
    assert!(!text.lines().any(|line| line.starts_with("lines")), "{text:?}");
    SHOWN.iter().for_each(|name| assert!(text.contains(name), "{text:?}"));
}

fn scenarios(text: &str) -> (Place, [String; 2]) {
    let place = Place::new();
    let files = NAMES.map(|name| format!("{name}.toml"));
    files.iter().for_each(|file| _ = place.block(file, text));
    (place, files)
}

#[test]
fn people_are_shown_what_a_terminal_would_obey() {
    let (place, [a, b]) = scenarios("[[expect]]\nmetric = \"duration_s\"\nmax = 0.001\n");
    let short = ["--set", "duration=0.01"];
    let run = |more: &[&str], code| place.runner(&[&[a.as_str(), &b][..], &short, more].concat()).exits(code);
    let Done { stdout, stderr, .. } = run(&["--slow", "1e-9", "--junit", "junit.xml", "-v"], 1);
    is_shown(&stdout);
    is_shown(&stderr);
    for words in ["failed e\\u", "slow: e\\u", "failed two\\n", "slow: two\\n", "  results/two\\nlines/"] {
        assert!(stdout.contains(words), "{words}: {stdout}");
    }
    is_shown(&place.runner(&["list", &a, &b]).exits(0).stdout);
    is_shown(&place.runner(&["check", &a, &b]).exits(0).stdout);
    is_shown(&place.runner(&["replay", "results"]).exits(0).stdout);
    is_shown(&run(&["--max-runs", "1"], 2).stderr.replace("two\\nlines.toml", "e\\u{1b}[31mred\\u{9b} two\\nlines"));

    // Programs are told the names themselves.
    let listed: serde_json::Value =
        serde_json::from_str(&place.runner(&["list", &a, &b, "--format", "json"]).exits(0).stdout).unwrap();
    assert_eq!([&listed[0]["scenario"], &listed[1]["scenario"]], NAMES);
    assert!(place.runner(&["list", &a, "--format", "csv"]).exits(0).stdout.contains(NAMES[0]));
    assert!(std::fs::read_to_string(place.path("results/summary.csv")).unwrap().contains(NAMES[0]));
    let told = run(&["--message-format", "json", "-o", "again"], 1).stdout;
    let told: Vec<serde_json::Value> = told.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(NAMES.iter().all(|name| told.iter().any(|line| line["scenario"] == *name)), "{told:?}");
}

#[test]
fn mistakes_in_such_files_are_shown_at_them() {
    let (place, [a, b]) = scenarios("[floor]\nfrction = 1\n");
    let said = place.runner(&["check", &a, &b]).exits(2).stderr;
    is_shown(&said);
    assert!(said.contains("two\\nlines.toml:4:1"), "{said}");
    is_shown(&place.runner(&["check", &format!("{a}x"), &format!("{b}x")]).exits(2).stderr);
    let said = place.runner(&["merge", &a, &b, "-o", "merged"]).exits(2).stderr;
    assert!(!said.contains('\u{1b}'), "{said:?}");
}
