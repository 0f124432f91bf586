//! Sessions at the console: what is said changes the run as it should, and a session that is saved is a scenario of the same bits.

mod answers;
mod lines;
mod recordings;
mod same_bits;
mod terminal;

use std::path::Path;

use crate::cli::{Done, Place, Table};

/// A session with a scenario, its lines from a file.
fn session(place: &Place, scenario: &str, lines: &str) -> Done {
    place.write("lines.txt", lines);
    place.runner(&["console", scenario, "--file", "lines.txt"])
}

/// What a session says to one more line than `before`, which says nothing of interest.
fn answer(place: &Place, scenario: &str, before: &str, line: &str) -> String {
    let done = session(place, scenario, &format!("{before}\n")).exits(0);
    let more = session(place, scenario, &format!("{before}\n{line}\n")).exits(0);
    more.stdout.strip_prefix(&done.stdout).expect("the same beginning").to_owned()
}

/// The numbers in a text.
fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// HOAP-2 on the floor with what `more` says.
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
