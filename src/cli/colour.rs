//! Decides whether output has colours: by `--color`, else only on a terminal.

use std::ffi::OsString;
use std::io::{IsTerminal, stderr, stdout};

use anstream::{AutoStream, ColorChoice};
use clap::ValueEnum;

/// When output has colours.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Colour {
    /// On a terminal; respects NO_COLOR and CLICOLOR_FORCE
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// Sets the choice for the whole program before parsing, so that usage errors have colours too.
pub fn decide(typed: impl Iterator<Item = OsString>) {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let choice = match last_choice(typed) {
        Colour::Always => ColorChoice::Always,
        Colour::Never => ColorChoice::Never,
        Colour::Auto if set("NO_COLOR").is_some() => ColorChoice::Never,
        Colour::Auto => match set("CLICOLOR_FORCE") {
            // By convention 0 means no; the library forces colours for any value.
            Some(value) if value == "0" && stdout().is_terminal() && stderr().is_terminal() => ColorChoice::Always,
            Some(value) if value == "0" => ColorChoice::Never,
            _ => ColorChoice::Auto,
        },
    };
    choice.write_global();
}

/// Are there colours on standard error?
pub fn on_stderr() -> bool {
    AutoStream::choice(&stderr()) != ColorChoice::Never
}

/// The last valid `--color` before `--`; the parser reports invalid values.
fn last_choice(typed: impl Iterator<Item = OsString>) -> Colour {
    let mut choice = Colour::Auto;
    let mut typed = typed.map(|word| word.to_string_lossy().into_owned()).take_while(|word| word != "--");
    while let Some(word) = typed.next() {
        let value = match word.strip_prefix("--color") {
            Some("") => typed.next(),
            Some(rest) => rest.strip_prefix('=').map(str::to_owned),
            None => None,
        };
        choice = value.and_then(|value| Colour::from_str(&value, false).ok()).unwrap_or(choice);
    }
    choice
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_option_is_found_wherever_it_stands() {
        let choice = |typed: &str| last_choice(typed.split(' ').map(OsString::from));
        assert_eq!(choice("runner a.toml"), Colour::Auto);
        assert_eq!(choice("runner a.toml --color never"), Colour::Never);
        assert_eq!(choice("runner check --color=always a.toml"), Colour::Always);
        assert_eq!(choice("runner --color=always --color never a.toml"), Colour::Never);
        assert_eq!(choice("runner --color"), Colour::Auto);
        assert_eq!(choice("runner --colour=never --color=blue"), Colour::Auto);
        assert_eq!(choice("runner -- --color=never"), Colour::Auto);
    }
}
