//! Errors of every kind have the same colours.

use super::{Done, Place};

/// What is said on standard error when colours are forced.
fn coloured(place: &Place, arguments: &[&str]) -> String {
    let mut command = place.command(arguments);
    command.env_remove("NO_COLOR").env("CLICOLOR_FORCE", "1");
    Done::from(command.output().unwrap()).exits(2).stderr
}

#[test]
fn errors_have_the_colours_of_diagnostics() {
    let place = Place::new();
    place.block("s.toml", "").block("wrong.toml", "[floor]\nfrction = 1\n").block("b/s.toml", "");
    let diagnostic = coloured(&place, &["wrong.toml"]);
    let word = &diagnostic[..diagnostic.find(": ").unwrap()];
    assert!(word.starts_with('\u{1b}') && word.contains("error"), "{word:?}");
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
        let said = coloured(&place, arguments);
        assert!(said.starts_with(word), "{arguments:?}: {said:?}");
        let plain = place.runner(arguments).exits(2).stderr;
        assert!(plain.starts_with("error: ") && !plain.contains('\u{1b}'), "{arguments:?}: {plain:?}");
    }
}
