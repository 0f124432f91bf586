//! What is wrong with a text that is no TOML, or not the TOML that is wanted, beyond what the parser says of it.

use std::ops::Range;

use toml::de::{DeTable, DeValue, Error};
use toml::value::Datetime;

/// Parts that a dotted key may have, as the parser has it.
const MOST_PARTS: usize = 80;

/// One mistake.
pub struct Mistake {
    /// Where, bytes of the text.
    pub piece: Range<usize>,
    /// What.
    pub message: String,
    /// What to do about it, where that is known.
    pub help: Option<String>,
}

/// Words for what the parser found in a text. `look` is whether it may be gone through once more to tell more of a key that is
/// there twice.
pub fn mistake(error: &Error, text: &str, look: bool) -> Mistake {
    let message = error.message().lines().collect::<Vec<_>>().join(" ");
    let Some(piece) = error.span().filter(|piece| text.get(piece.clone()).is_some()) else {
        // Only keys of too many parts are told without their place.
        let piece = deep_key(text).unwrap_or_else(|| last_line(text));
        let message = match message.as_str() {
            "recursion limit" => format!("a dotted key has more than {MOST_PARTS} parts"),
            _ => message,
        };
        return Mistake { piece, message, help: None };
    };
    if is_duplicate(&message) {
        let twice = if look { twice(text, &piece) } else { None };
        let (path, first) = twice.unwrap_or_else(|| (vec![name(&text[piece.clone()])], None));
        let line = |at: usize| text[..at].matches('\n').count() + 1;
        let help = match first {
            Some(first) => format!("the first is on line {}; keep one of them", line(first.start)),
            None => "a key may be given once in a table, and a table once in a file; keep one of them".into(),
        };
        return Mistake { piece, message: format!("{DUPLICATE} `{}`", dotted(&path)), help: Some(help) };
    }
    // To serde a date is a table with one strange key.
    let written = text[piece.clone()].trim();
    let message = match message.strip_prefix("invalid type: map, ") {
        Some(wanted) if written.parse::<Datetime>().is_ok() => {
            format!("invalid type: the date or time {written}, {wanted}")
        }
        _ => message,
    };
    Mistake { piece, message, help: None }
}

const DUPLICATE: &str = "duplicate key";

fn is_duplicate(message: &str) -> bool {
    message.starts_with(DUPLICATE)
}

/// The dotted path of the key that is there twice, if [`mistake`] said this of one.
pub fn duplicate(message: &str) -> Option<&str> {
    message.strip_prefix(DUPLICATE)?.strip_prefix(" `")?.strip_suffix('`')
}

/// The path of a key that is there for the second time at `piece`, and where it is for the first time.
fn twice(text: &str, piece: &Range<usize>) -> Option<(Vec<String>, Option<Range<usize>>)> {
    // Under another name, which nobody takes, it has its place in the tree; the parser drops it otherwise.
    let other = [&text[..piece.start], "\"\\u0001\\u0002\"", &text[piece.end..]].concat();
    let (document, _) = DeTable::parse_recoverable(&other);
    let (mut path, mut table) = (Vec::new(), None);
    if !find(document.get_ref(), piece.start, &mut path, &mut table) {
        return None;
    }
    let name = name(&text[piece.clone()]);
    let first = table?.iter().find(|(key, _)| key.get_ref().as_ref() == name).map(|(key, _)| key.span());
    path.push(name);
    Some((path, first.filter(|first| first.start < piece.start)))
}

/// Looks for the table with a key that begins at a byte; `path` is what leads there.
fn find<'t, 'i>(
    table: &'t DeTable<'i>,
    at: usize,
    path: &mut Vec<String>,
    found: &mut Option<&'t DeTable<'i>>,
) -> bool {
    if table.iter().any(|(key, _)| key.span().start == at) {
        *found = Some(table);
        return true;
    }
    table.iter().any(|(key, value)| {
        path.push(key.get_ref().to_string());
        let is_here = find_in(value.get_ref(), at, path, found);
        if !is_here {
            path.pop();
        }
        is_here
    })
}

fn find_in<'t, 'i>(
    value: &'t DeValue<'i>,
    at: usize,
    path: &mut Vec<String>,
    found: &mut Option<&'t DeTable<'i>>,
) -> bool {
    match value {
        DeValue::Table(table) => find(table, at, path, found),
        DeValue::Array(items) => items.iter().enumerate().any(|(index, item)| {
            path.push(index.to_string());
            let is_here = find_in(item.get_ref(), at, path, found);
            if !is_here {
                path.pop();
            }
            is_here
        }),
        _ => false,
    }
}

/// A key as it is written, without its quotes.
fn name(written: &str) -> String {
    let table = format!("{written} = 0").parse::<toml::Table>().ok();
    table.and_then(|table| table.keys().next().cloned()).unwrap_or_else(|| written.to_owned())
}

/// A path as a dotted key, names in quotes where they are no bare keys.
pub fn dotted(path: &[String]) -> String {
    path.iter().map(|name| segment(name)).collect::<Vec<_>>().join(".")
}

/// A name as a part of a dotted key.
pub fn segment(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    if !name.is_empty() && name.chars().all(bare) { name.to_owned() } else { format!("{name:?}") }
}

/// The first key of more parts than the parser takes.
fn deep_key(text: &str) -> Option<Range<usize>> {
    let bytes = text.as_bytes();
    let mut at = 0;
    // Where the key began, how many parts it has so far, and was a dot the last thing of it?
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
        if parts > MOST_PARTS {
            return Some(start..at);
        }
    }
    None
}

/// The last line that has something on it.
fn last_line(text: &str) -> Range<usize> {
    let end = text.trim_end().len();
    text[..end].rfind('\n').map_or(0, |at| at + 1)..end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_is_there_twice_has_a_path_and_a_first_place() {
        for (text, path, first) in [
            ("a = 1\nb = 2\na = 3\n", "a", Some(0)),
            ("[t]\nx = 1\n[t.u]\n\"y.z\" = 1\n'y.z' = 2\n", "t.u.\"y.z\"", Some(16)),
            ("[[l]]\nx = 1\n[[l]]\nx = 2\nx = 3\n", "l.1.x", Some(18)),
            ("t = { x = 1, y = [{ z = 1, z = 2 }] }\n", "t.y.0.z", Some(20)),
            ("[t]\nx = 1\n[t]\ny = 1\n", "t", Some(1)),
            ("a.b = 1\na.b = 2\n", "a.b", Some(2)),
        ] {
            let (_, errors) = DeTable::parse_recoverable(text);
            let piece = errors[0].span().unwrap();
            assert!(is_duplicate(errors[0].message()), "{text}");
            let (found, at) = twice(text, &piece).unwrap_or_else(|| panic!("{text}"));
            assert_eq!((dotted(&found).as_str(), at.map(|at| at.start)), (path, first), "{text}");
        }
    }

    #[test]
    fn a_key_of_too_many_parts_is_found() {
        let deep = vec!["a"; MOST_PARTS + 1].join(".");
        for (before, after) in [
            ("", " = 1\n"),
            ("x = 1 # a.b\n", " = 1\n"),
            ("[", "]\n"),
            ("y = [0.1, 0.2]\nx = { b = \"a.b\", ", " = 1 }\n"),
        ] {
            let text = format!("{before}{deep}{after}");
            let (_, errors) = DeTable::parse_recoverable(&text);
            let mistake = mistake(&errors[0], &text, true);
            assert_eq!(mistake.message, "a dotted key has more than 80 parts", "{text}");
            assert_eq!(mistake.piece, before.len()..before.len() + deep.len(), "{text}");
        }
        let most = vec!["a"; MOST_PARTS].join(".");
        assert_eq!(deep_key(&format!("{most} = 1\n# {deep}\nx = \"{deep}\"\n")), None);
        assert!(DeTable::parse(&format!("{most} = 1")).is_ok());
        assert_eq!(last_line("a\nbc\n\n"), 2..4);
    }
}
