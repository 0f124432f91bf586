//! Describes TOML errors beyond the parser's message: the path of a duplicate key, the position of
//! a key that is too deep.

use std::ops::Range;

use toml::de::{DeTable, Error};
use toml::value::Datetime;

use super::toml_tree::Node;

/// Greatest number of parts of a dotted key that the parser accepts.
const MAX_KEY_PARTS: usize = 80;

/// One error in a TOML text.
pub struct TomlError {
    /// Bytes of the text.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// How to correct it, if known.
    pub help: Option<String>,
}

impl TomlError {
    /// Describes an error of the parser. With `find_duplicates` a duplicate key is reported with
    /// its path and the line of the first one, which takes another pass over the text.
    pub fn new(error: &Error, text: &str, find_duplicates: bool) -> TomlError {
        let message = error.message().lines().collect::<Vec<_>>().join(" ");
        let Some(span) = error.span().filter(|span| text.get(span.clone()).is_some()) else {
            // The parser reports a position for all errors except keys with too many parts.
            let span = deep_key(text).unwrap_or_else(|| last_line(text));
            let message = match message.as_str() {
                "recursion limit" => format!("a dotted key has more than {MAX_KEY_PARTS} parts"),
                _ => message,
            };
            return TomlError { span, message, help: None };
        };
        if message.starts_with(DUPLICATE) {
            let found = if find_duplicates { duplicate_path(text, &span) } else { None };
            let (path, first) = found.unwrap_or_else(|| (vec![name(&text[span.clone()])], None));
            let line = |at: usize| text[..at].matches('\n').count() + 1;
            let help = match first {
                Some(first) => format!("the first is on line {}; keep one of them", line(first.start)),
                None => "a key may be given once in a table, and a table once in a file; keep one of them".into(),
            };
            return TomlError { span, message: format!("{DUPLICATE} `{}`", dotted(&path)), help: Some(help) };
        }
        // To serde a date is a table with one special key.
        let written = text[span.clone()].trim();
        let message = match message.strip_prefix("invalid type: map, ") {
            Some(expected) if written.parse::<Datetime>().is_ok() => {
                format!("invalid type: the date or time {written}, {expected}")
            }
            _ => message,
        };
        TomlError { span, message, help: None }
    }
}

const DUPLICATE: &str = "duplicate key";

/// The dotted path of the duplicate key, if a message of [`TomlError::new`] reports one.
pub fn duplicate_key(message: &str) -> Option<&str> {
    message.strip_prefix(DUPLICATE)?.strip_prefix(" `")?.strip_suffix('`')
}

/// The path of the duplicate key at `span`, and the position of the first one.
fn duplicate_path(text: &str, span: &Range<usize>) -> Option<(Vec<String>, Option<Range<usize>>)> {
    // The parser drops a duplicate key. Renamed to a key that no file uses, it stays in the tree.
    let renamed = [&text[..span.start], "\"\\u0001\\u0002\"", &text[span.end..]].concat();
    let root = Node::of(DeTable::parse_recoverable(&renamed).0.get_ref(), 0, &mut Vec::new());
    let mut path = root.path_at(span.start)?;
    path.pop();
    let table = path.iter().try_fold(&root, |node, key| match key.parse::<usize>() {
        Ok(index) if !node.items().is_empty() => node.items().get(index),
        _ => node.get(key),
    })?;
    let name = name(&text[span.clone()]);
    let first = table.entry(&name).map(|entry| entry.key_span.clone());
    path.push(name);
    Some((path, first.filter(|first| first.start < span.start)))
}

/// A key without its quotes.
fn name(written: &str) -> String {
    let table = format!("{written} = 0").parse::<toml::Table>().ok();
    table.and_then(|table| table.keys().next().cloned()).unwrap_or_else(|| written.to_owned())
}

/// A path as a dotted key; names that are not bare keys are quoted.
pub fn dotted(path: &[String]) -> String {
    path.iter().map(|name| segment(name)).collect::<Vec<_>>().join(".")
}

/// A name as a part of a dotted key.
pub fn segment(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    if !name.is_empty() && name.chars().all(bare) { name.to_owned() } else { format!("{name:?}") }
}

/// The first key with more parts than the parser accepts.
fn deep_key(text: &str) -> Option<Range<usize>> {
    let bytes = text.as_bytes();
    let mut at = 0;
    // Start of the key, number of its parts so far, and whether its last character was a dot.
    let (mut start, mut parts, mut is_open) = (0, 0, false);
    while at < bytes.len() {
        let from = at;
        at += 1;
        let is_part = match bytes[from] {
            quote @ (b'"' | b'\'') => {
                while at < bytes.len() && bytes[at] != quote && bytes[at] != b'\n' {
                    at += 1 + usize::from(quote == b'"' && bytes[at] == b'\\');
                }
                at = (at + 1).min(bytes.len());
                true
            }
            b if b.is_ascii_alphanumeric() || b == b'_' || b == b'-' => {
                while at < bytes.len() && (bytes[at].is_ascii_alphanumeric() || b"_-".contains(&bytes[at])) {
                    at += 1;
                }
                true
            }
            b'.' => {
                is_open = parts > 0;
                continue;
            }
            b' ' | b'\t' => continue,
            b'#' => {
                at = text[at..].find('\n').map_or(bytes.len(), |end| at + end);
                false
            }
            _ => false,
        };
        (start, parts) = match (is_part, is_open) {
            (true, true) => (start, parts + 1),
            (true, false) => (from, 1),
            (false, _) => (from, 0),
        };
        is_open = false;
        if parts > MAX_KEY_PARTS {
            return Some(start..at);
        }
    }
    None
}

/// The last line that is not empty.
fn last_line(text: &str) -> Range<usize> {
    let end = text.trim_end().len();
    text[..end].rfind('\n').map_or(0, |at| at + 1)..end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duplicate_key_has_a_path_and_a_first_position() {
        for (text, path, first) in [
            ("a = 1\nb = 2\na = 3\n", "a", Some(0)),
            ("[t]\nx = 1\n[t.u]\n\"y.z\" = 1\n'y.z' = 2\n", "t.u.\"y.z\"", Some(16)),
            ("[[l]]\nx = 1\n[[l]]\nx = 2\nx = 3\n", "l.1.x", Some(18)),
            ("t = { x = 1, y = [{ z = 1, z = 2 }] }\n", "t.y.0.z", Some(20)),
            ("[t]\nx = 1\n[t]\ny = 1\n", "t", Some(1)),
            ("a.b = 1\na.b = 2\n", "a.b", Some(2)),
        ] {
            let (_, errors) = DeTable::parse_recoverable(text);
            let span = errors[0].span().unwrap();
            assert!(errors[0].message().starts_with(DUPLICATE), "{text}");
            let (found, at) = duplicate_path(text, &span).unwrap_or_else(|| panic!("{text}"));
            assert_eq!((dotted(&found).as_str(), at.map(|at| at.start)), (path, first), "{text}");
        }
    }

    #[test]
    fn a_key_of_too_many_parts_is_found() {
        let deep = vec!["a"; MAX_KEY_PARTS + 1].join(".");
        for (before, after) in [
            ("", " = 1\n"),
            ("x = 1 # a.b\n", " = 1\n"),
            ("[", "]\n"),
            ("y = [0.1, 0.2]\nx = { b = \"a.b\", ", " = 1 }\n"),
        ] {
            let text = format!("{before}{deep}{after}");
            let (_, errors) = DeTable::parse_recoverable(&text);
            let error = TomlError::new(&errors[0], &text, true);
            assert_eq!(error.message, "a dotted key has more than 80 parts", "{text}");
            assert_eq!(error.span, before.len()..before.len() + deep.len(), "{text}");
        }
        let longest = vec!["a"; MAX_KEY_PARTS].join(".");
        assert_eq!(deep_key(&format!("{longest} = 1\n# {deep}\nx = \"{deep}\"\n")), None);
        assert!(DeTable::parse(&format!("{longest} = 1")).is_ok());
        assert_eq!(last_line("a\nbc\n\n"), 2..4);
    }
}
