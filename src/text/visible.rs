//! Words that came from outside, such as names of files, for a person at a terminal.

use std::borrow::Cow;
use std::path::Path;

/// With control characters written as Rust writes them (`\n`, `\u{1b}`): a terminal would obey them. All others stay.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.chars().any(char::is_control) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        match c.is_control() {
            true => out.extend(c.escape_debug()),
            false => out.push(c),
        }
    }
    out.into()
}

/// The same of a text of several lines, whose breaks stay.
pub fn visible_lines(text: &str) -> String {
    text.split('\n').map(visible).collect::<Vec<_>>().join("\n")
}

/// A path, likewise.
pub fn visible_path(path: &Path) -> String {
    visible(&path.display().to_string()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_written_out_and_no_others() {
        assert_eq!(visible("e\u{1b}[31m\nr\u{9b}\u{7f}"), "e\\u{1b}[31m\\nr\\u{9b}\\u{7f}");
        assert_eq!(visible_lines("a\t\nb\u{1b}"), "a\\t\nb\\u{1b}");
        assert_eq!(visible("é \\ \" \u{301} 足\u{200d}"), "é \\ \" \u{301} 足\u{200d}");
    }
}
