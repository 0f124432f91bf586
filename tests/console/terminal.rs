//! Test of a session at a terminal.

use std::path::Path;
use std::process::Command;

use crate::cli::Place;

/// Completes lines, types while the run continues, pauses with Ctrl-C and ends with Ctrl-D. The
/// pseudo-terminal comes from Python; without Python the test is skipped.
#[test]
fn a_terminal_session_completes_runs_pauses_and_ends() {
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
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{stdout}{stderr}");
    let saved = std::fs::read_to_string(place.path("s.toml")).unwrap();
    assert!(saved.contains("\"floor.friction\""), "{saved}");
    // The history contains the typed lines.
    let history = std::fs::read_to_string(place.path("state/stiction/console-history")).unwrap();
    assert!(history.contains("floor 0.3 0.2"), "{history}");
    place.runner(&["s.toml"]).exits(0);
}
