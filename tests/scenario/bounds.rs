//! Values that would need too much memory or time are refused when the scenario is read.

use std::path::Path;
use stiction::scenario;

#[track_caller]
fn refused(text: &str, message: &str) {
    let text = format!("robot = {{ model = \"r.toml\" }}\n{text}\n");
    let found = scenario::parse(Path::new("s.toml"), text.clone())
        .and_then(|f| f.expand(&[]))
        .err()
        .unwrap_or_else(|| panic!("accepted: {text}"));
    let found = found.to_string();
    assert!(found.contains(message) && found.contains("s.toml:"), "{text}{found}");
}

#[track_caller]
fn accepted(text: &str) {
    let text = format!("robot = {{ model = \"r.toml\" }}\n{text}\n");
    let runs = scenario::parse(Path::new("s.toml"), text).and_then(|f| f.expand(&[]));
    runs.unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn rates_and_delays_have_bounds() {
    refused("[control]\nrate = 1e9", "must be at most 1000000 Hz, not 1000000000");
    refused("[control]\nrate = 0", "must be greater than 0");
    accepted("[control]\nrate = 1e6");
    let delay = |rate: &str| format!("[control]\nrate = {rate}\n[sensors]\ngyroscope = {{ delay = 10.0 }}");
    accepted(&delay("1e4"));
    refused(&delay("2e4"), "`sensors.gyroscope.delay` must be at most 100000 ticks, that is 5 s");
}

#[test]
fn walks_have_bounds() {
    let walk = |rest: &str| format!("[[task]]\ntype = \"walk\"\n{rest}");
    // Steps beyond the end of the run are not planned.
    accepted(&format!("duration = 5\n{}", walk("steps = 4000000000")));
    accepted(&format!("duration = 5\n{}", walk("wait = 1e12")));
    refused(&format!("duration = 1e6\n{}", walk("steps = 4000000000")), "`task.0.steps` makes a walk of 999999 s");
    refused(&format!("duration = 1e6\n{}", walk("wait = 1e12")), "`task.0.wait` makes a walk of 999999 s");
    refused(&walk("step_time = 1e-6\ndouble_support = 0"), "`task.0.step_time` must be at least 0.05 s");
}

#[test]
fn values_without_meaning_are_refused() {
    let balance = |rest: &str| format!("[[task]]\ntype = \"balance\"\n{rest}");
    refused(
        &balance("control = \"force\"\nposition = { leaning = 1 }"),
        "`task.0.position` has no meaning with this `control`",
    );
    refused(
        &balance("control = \"position\"\nforce = { margin = 0.2 }"),
        "`task.0.force` has no meaning with this `control`",
    );
    refused(&balance("control = \"position\"\nposition = { damping = -0.1 }"), "0 or greater, not -0.1");
    refused(&balance("control = \"position\"\nposition = { proportional = -0.1 }"), "0 or greater, not -0.1");
    let script = "[[task]]\ntype = \"script\"\nfile = \"s.luau\"\nstart = 1\nchange = [{ at = 0.5, params = {} }]";
    refused(script, "`task.0.change.0.at` must not be before `start` = 1, not 0.5");
}
