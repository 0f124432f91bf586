//! Any single mistyped key of a valid file is an error with its line.

use std::collections::BTreeSet;
use std::ops::Range;

use proptest::prelude::*;

use stiction::scenario::{METRICS, parse_override, schema};

use super::{FULL, SEARCHES, file, runs};

/// Keys with free names: joints and script parameters.
const NAMES: [&str; 1] = ["left_knee"];

/// Every key of a file that the format knows, by its byte range.
fn keys(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let word = |b: u8| b.is_ascii_alphanumeric() || b == b'_';
    let mut keys = Vec::new();
    let mut i = 0;
    let (mut line_start, mut quoted, mut comment) = (true, false, false);
    while i < bytes.len() {
        match bytes[i] {
            b'\n' => (line_start, comment) = (true, false),
            b'#' if !quoted => comment = true,
            b'"' if !comment => quoted = !quoted,
            b if word(b) && !quoted && !comment => {
                let start = i;
                while word(bytes[i]) {
                    i += 1;
                }
                let after = text[i..].trim_start_matches(' ').as_bytes()[0];
                // `key =`, or the name in a header.
                if after == b'=' || (line_start && after == b']') {
                    keys.push(start..i);
                }
                line_start = false;
                continue;
            }
            _ => {}
        }
        i += 1;
    }
    keys.retain(|k| !NAMES.contains(&&text[k.clone()]));
    keys
}

/// Files that have all keys of the format together.
fn files() -> impl Iterator<Item = &'static str> {
    [FULL].into_iter().chain(SEARCHES)
}

#[test]
fn the_keys_are_found() {
    let keys: Vec<_> = keys(FULL).into_iter().map(|k| &FULL[k]).collect();
    assert!(keys.len() > 300, "{}", keys.len());
    for key in
        ["schema", "robot", "rpy", "polygon", "inertia", "coulomb", "task", "type", "profile", "logspace", "repeat"]
    {
        assert!(keys.contains(&key), "{key}");
    }
    assert_eq!(runs(FULL).len(), 30, "the file itself is sound");
    assert_eq!(SEARCHES.map(|text| runs(text).len()), [4, 2, 2, 2], "both ends of each search");
}

/// The errors when the key at `range` is written as `typo`; `None` if that is no mistyped key.
fn mistyped(full: &str, keys: &[Range<usize>], range: &Range<usize>, typo: &str) -> Result<(), String> {
    // A typo that is itself a key of the format, a metric, or no key at all is a different error.
    let is_key = keys.iter().any(|k| &full[k.clone()] == typo) || METRICS.contains(&typo);
    if typo.is_empty() || is_key {
        return Ok(());
    }
    let text = format!("{}{typo}{}", &full[..range.start], &full[range.end..]);
    let line = full[..range.start].matches('\n').count() + 1;
    match file(&text).and_then(|f| f.expand(&[])) {
        Ok(_) => Err(format!("`{typo}` for `{}` on line {line} is accepted", &full[range.clone()])),
        Err(found) => {
            let named = found.iter().any(|d| d.position.is_some_and(|p| p.line == line) && d.message.contains(typo));
            if named { Ok(()) } else { Err(format!("line {line}, `{typo}`:\n{found}")) }
        }
    }
}

#[test]
fn an_extra_or_missing_letter_in_any_key_is_an_error() {
    for text in files() {
        let keys = keys(text);
        let wrong = |range: &Range<usize>| {
            let key = &text[range.clone()];
            [format!("{key}x"), key[..key.len() - 1].to_owned()].map(|typo| mistyped(text, &keys, range, &typo))
        };
        let wrong: Vec<String> = keys.iter().flat_map(wrong).filter_map(Result::err).collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}

/// Every key of the schema is in one of [`files`], and so is every type of task and force.
#[test]
fn nothing_of_the_format_is_missing() {
    let mut schema = schema();
    // Notations for the values of a sweep; one is enough.
    let definitions = schema["$defs"].as_object_mut().expect("definitions");
    definitions.retain(|name, _| !["Axis", "Distribution"].contains(&name.as_str()));
    let known: BTreeSet<&str> = files().flat_map(|text| keys(text).into_iter().map(|k| &text[k])).collect();
    let mut missing = BTreeSet::new();
    let mut rest = vec![&schema];
    while let Some(value) = rest.pop() {
        if let Some(properties) = value["properties"].as_object() {
            let name = |key: &&String| !known.contains(key.as_str());
            missing.extend(properties.keys().filter(name).map(|key| format!("key `{key}`")));
            if let Some(word) = properties.get("type").and_then(|t| t["const"].as_str())
                && !FULL.contains(&format!("type = \"{word}\""))
            {
                missing.insert(format!("type `{word}`"));
            }
        }
        rest.extend(
            value.as_object().into_iter().flat_map(|o| o.values()).chain(value.as_array().into_iter().flatten()),
        );
    }
    assert!(missing.is_empty(), "{missing:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_mistyped_key_is_an_error_on_its_line(
        which in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        letter in "[a-z_]",
        how in 0..4,
    ) {
        let keys = keys(FULL);
        let range = &keys[which.index(keys.len())];
        let key = &FULL[range.clone()];
        let i = at.index(key.len());
        let typo = match how {
            0 => format!("{}{letter}{}", &key[..i], &key[i..]),
            1 => format!("{}{}", &key[..i], &key[i + 1..]),
            2 => format!("{}{letter}{}", &key[..i], &key[i + 1..]),
            _ => {
                let mut letters: Vec<char> = key.chars().collect();
                letters.swap(i, (i + 1).min(key.len() - 1));
                letters.into_iter().collect()
            }
        };
        if let Err(wrong) = mistyped(FULL, &keys, range, &typo) {
            prop_assert!(false, "{}", wrong);
        }
    }

    /// Text that is cut, duplicated or has inserted characters is accepted or refused, and its
    /// errors can be printed.
    #[test]
    fn no_text_makes_the_reader_panic(
        cut in any::<(prop::sample::Index, prop::sample::Index)>(),
        junk in "[\\PC\n\"\\[\\]{}=.,#0-9]{0,12}",
        assignment in ("[a-z_.0-9\"]{1,20}", "[0-9a-z\\[\\]\",.{}= -]{0,12}"),
    ) {
        let (a, b) = (cut.0.index(FULL.len()), cut.1.index(FULL.len()));
        let text = format!("{}{junk}{}", &FULL[..a], &FULL[b..]);
        let overrides: Vec<_> = parse_override(&format!("{}={}", assignment.0, assignment.1)).into_iter().collect();
        match file(&text).and_then(|f| f.expand(&overrides)) {
            Ok(runs) => prop_assert!(!runs.is_empty()),
            Err(found) => {
                prop_assert!(found.has_errors());
                prop_assert!(!found.to_string().is_empty());
            }
        }
    }
}
