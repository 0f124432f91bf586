//! `runner scenarios/validation` as one command.

use std::path::Path;
use std::process::{Command, Output};

use super::case::{files, folder};
use crate::cli::Table;
use crate::support::runs::root;

fn runner(arguments: &[&Path]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_runner")).args(arguments).current_dir(root()).output().expect("it starts")
}

fn lines(output: &Output) -> Vec<String> {
    String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect()
}

#[test]
fn it_exits_0_and_prints_measured_expected_and_error_per_case() {
    let results = tempfile::tempdir().expect("a folder for results");
    let output = runner(&[&folder(), "-o".as_ref(), results.path(), "--verdicts".as_ref(), "values".as_ref()]);
    let messages = lines(&output);
    let shown = messages.iter().skip_while(|l| !l.contains("measured")).skip(1).collect::<Vec<_>>();
    let failed: Vec<_> = shown.iter().filter(|l| l.ends_with(" NO")).collect();
    assert_eq!(output.status.code(), Some(0), "{failed:#?}\n{}", String::from_utf8_lossy(&output.stderr));
    assert!(failed.is_empty());
    // Every expected value of a run has its line, and every run has one.
    let log = std::fs::read_to_string(results.path().join("runs.jsonl")).expect("it is written");
    let (mut runs, mut values, mut all) = (0, 0, 0);
    for line in log.lines() {
        let run: serde_json::Value = serde_json::from_str(line).expect("JSON");
        let verdicts = run["verdicts"].as_array().expect("verdicts");
        let of_run = verdicts.iter().filter(|v| v["truth"].is_number()).count();
        assert!(of_run > 0, "{}", run["scenario"]);
        for verdict in verdicts.iter().filter(|v| v["truth"].is_number()) {
            let [measured, truth, error] =
                ["measured", "truth", "error"].map(|k| verdict[k].as_f64().expect("a number"));
            assert_eq!(measured - truth, error);
        }
        (runs, values, all) = (runs + 1, values + of_run, all + verdicts.len());
    }
    assert_eq!(shown.iter().filter(|l| l.ends_with(" yes")).count(), values);
    assert!(shown.iter().any(|l| l.starts_with(&format!("{all} of {all} expectations held"))), "{:?}", messages.last());
    assert_eq!(Table::read(&results.path().join("summary.csv")).rows.len(), runs);
}

#[test]
fn a_folder_selects_the_files_in_it() {
    let paths: Vec<_> = files().into_iter().map(|(_, path)| path).collect();
    let mut named: Vec<&Path> = vec!["list".as_ref()];
    named.extend(paths.iter().map(|p| p.as_path()));
    let (by_folder, by_file) = (runner(&["list".as_ref(), &folder()]), runner(&named));
    assert_eq!(by_folder.status.code(), Some(0));
    assert_eq!(lines(&by_folder), lines(&by_file));
    assert!(lines(&by_folder).len() > 300);
}
