//! Makes control characters in foreign text visible, such as those in file names.

use std::borrow::Cow;
use std::path::Path;

/// The text with control characters as Rust escapes (`\n`, `\u{1b}`), so that terminals do not
/// interpret them.
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

/// As [`visible`], for a text of several lines; line breaks are kept.
pub fn visible_lines(text: &str) -> String {
    text.split('\n').map(visible).collect::<Vec<_>>().join("\n")
}

/// As [`visible`], for a path.
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
