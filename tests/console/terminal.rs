//! A person at a terminal.

use std::path::Path;
use std::process::Command;

use crate::cli::Place;

/// Lines are completed, what runs goes on while others are typed, Ctrl-C holds it, Ctrl-D ends the session. Python has terminals for
/// tests; without it there is none.
#[test]
fn a_person_completes_runs_holds_and_ends() {
    if !cfg!(unix) || !Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success()) {
        return;
    }
    let place = Place::new();
    place.block("b.toml", "");
    let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/console/terminal.py");
    let output = Command::new("python3")
        .arg(client)
        .args([env!("CARGO_BIN_EXE_runner"), "console", "b.toml", "--save", "s.toml"])
        .current_dir(place.path(""))
        .env("XDG_STATE_HOME", place.path("state"))
        .output()
        .unwrap();
    let (said, wrong) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{said}{wrong}");
    let saved = std::fs::read_to_string(place.path("s.toml")).unwrap();
    assert!(saved.contains("\"floor.friction\""), "{saved}");
    // What was typed is remembered.
    let history = std::fs::read_to_string(place.path("state/stiction/console-history")).unwrap();
    assert!(history.contains("floor 0.3 0.2"), "{history}");
    place.runner(&["s.toml"]).exits(0);
}
