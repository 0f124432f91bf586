//! Tests of console sessions: commands change the run as documented, and a saved session is a
//! scenario that gives the same bits.

mod answers;
mod lines;
mod objects;
mod recordings;
mod same_bits;
mod terminal;

use std::path::Path;

use crate::cli::{Done, Place, Table};

/// Runs a session with a scenario and the lines of a file.
fn session(place: &Place, scenario: &str, lines: &str) -> Done {
    place.write("lines.txt", lines);
    place.runner(&["console", scenario, "--file", "lines.txt"])
}

/// Output of a session for `line`, after the lines of `before`.
fn answer(place: &Place, scenario: &str, before: &str, line: &str) -> String {
    let done = session(place, scenario, &format!("{before}\n")).exits(0);
    let more = session(place, scenario, &format!("{before}\n{line}\n")).exits(0);
    more.stdout.strip_prefix(&done.stdout).expect("the output for the earlier lines").to_owned()
}

/// The numbers in a text.
fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// Writes a scenario of HOAP-2 on the floor, with the lines of `more`.
fn hoap2(place: &Place, name: &str, more: &str) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    place.write(name, format!("{more}\n[robot]\nmodel = {model:?}\n"));
}

fn export(place: &Place, log: &str, more: &[&str]) -> Table {
    let arguments = [&["export", log][..], more].concat();
    Table::parse(&place.runner(&arguments).exits(0).stdout)
}

/// The log of the only run of a scenario.
fn log_of(place: &Place, results: &str, scenario: &str) -> String {
    let folder = std::fs::read_dir(place.path(results).join(scenario)).unwrap().next().unwrap().unwrap().path();
    folder.join("log.mcap").to_str().unwrap().to_owned()
}
