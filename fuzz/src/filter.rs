//! Expressions of `--filter`, applied to runs of a sweep.

use stiction::batch::{Filter, Selection};
use stiction::scenario::Run;

use super::tree;

/// Expressions with each part of the grammar.
pub const SEEDS: [&str; 7] = [
    "name ~ \"fuzz*\" and (contact.method == \"exact\" or not floor.friction.static >= 0.5)",
    "key ^= \"01\" or name !~ 'a?b'",
    "floor.friction.static in [0.3, 0.5, 1e-3,]",
    "contact.method in [\"exact\", \"one-step\"]",
    "log.problems == true and duration < 30 deg",
    "robot.posture.\"left knee\" != 0.5 and seed <= 3",
    "not (not (seed > -1))",
];

thread_local! {
    static RUNS: Vec<Run> = ["exact", "one-step"].map(|method| tree::run(&format!(
        "robot.model = \"../robots/block/block.toml\"\nfloor.friction = 0.3\ncontact.method = \"{method}\"\n"
    ))).into();
}

/// Reads an expression.
pub fn take(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let filter = match Filter::parse(text) {
        Ok(filter) => filter,
        Err(error) => return drop((error.render(false), error.render(true))),
    };
    let written = filter.to_string();
    let again = Filter::parse(&written).unwrap_or_else(|error| panic!("{written}: {}", error.render(false)));
    assert_eq!(again.to_string(), written);
    RUNS.with(|runs| {
        let select = |filter: &Filter| {
            let mut selection = Selection::new(filter);
            let taken: Vec<bool> = runs.iter().map(|run| selection.takes(run, "0123456789abcdef")).collect();
            if let Err(error) = selection.end() {
                let _ = (error.render(false), error.render(true));
            }
            taken
        };
        assert_eq!(select(&filter), select(&again), "{text} and {written} differ");
    });
}
