//! Tests that all kinds of errors have the same colours.

use super::{Done, Place};

/// Standard error with forced colours.
fn stderr_with_colours(place: &Place, arguments: &[&str]) -> String {
    let mut command = place.command(arguments);
    command.env_remove("NO_COLOR").env("CLICOLOR_FORCE", "1");
    Done::from(command.output().unwrap()).exits(2).stderr
}

#[test]
fn errors_of_all_commands_have_the_colours_of_diagnostics() {
    let place = Place::new();
    place.block("s.toml", "").block("wrong.toml", "[floor]\nfrction = 1\n").block("b/s.toml", "");
    let diagnostic = stderr_with_colours(&place, &["wrong.toml"]);
    let prefix = &diagnostic[..diagnostic.find(": ").unwrap()];
    assert!(prefix.starts_with('\u{1b}') && prefix.contains("error"), "{prefix:?}");
    for arguments in [
        &["merge", "nowhere", "-o", "merged"][..],
        &["run", "s.toml", "-o", "s.toml"],
        &["run", "nowhere.toml"],
        &["s.toml", "b/s.toml"],
        &["report", "nowhere"],
        &["compare", "nowhere", "nowhere"],
        &["export", "nowhere"],
        &["replay", "nowhere"],
        &["view", "nowhere"],
    ] {
        let stderr = stderr_with_colours(&place, arguments);
        assert!(stderr.starts_with(prefix), "{arguments:?}: {stderr:?}");
        let plain = place.runner(arguments).exits(2).stderr;
        assert!(plain.starts_with("error: ") && !plain.contains('\u{1b}'), "{arguments:?}: {plain:?}");
    }
}
