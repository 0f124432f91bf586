//! Scenario files as input of users: accepted and refused texts, and positions of errors.

mod bounds;
mod broken;
mod defaults;
mod expansion;
mod list;
mod random;
mod schema;
mod shown;
mod terrain;
mod typos;
mod verdicts;
mod world;

use std::path::Path;

use stiction::scenario::{Diagnostics, Run, ScenarioFile, parse};

/// Every available part of the format but `[search]`.
pub const FULL: &str = include_str!("full.toml");

/// Every key of `[search]`, in the combinations that are possible.
pub const SEARCHES: [&str; 4] = [
    include_str!("search/one-key.toml"),
    include_str!("search/two-keys.toml"),
    include_str!("search/least.toml"),
    include_str!("search/greatest.toml"),
];

/// The smallest scenario.
pub const SMALLEST: &str = "[robot]\nmodel = \"block.urdf\"\n";

/// A scenario file with a unique name, not on disk.
fn file(text: &str) -> Result<ScenarioFile, Diagnostics> {
    parse(Path::new("scenarios/test.toml"), text)
}

/// The runs of a valid text.
fn runs(text: &str) -> Vec<Run> {
    match file(text).and_then(|f| f.expand(&[])) {
        Ok(runs) => runs,
        Err(wrong) => panic!("{wrong}"),
    }
}

/// The errors of a text with overrides.
fn wrong(text: &str, overrides: &[(String, toml::Value)]) -> Diagnostics {
    match file(text).and_then(|f| f.expand(overrides)) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(wrong) => wrong,
    }
}
