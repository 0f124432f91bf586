//! Any single mistyped key of a sound file is an error that names its line.

use proptest::prelude::*;

use stiction::scenario::{METRICS, parse_override};

use super::{FULL, file, runs};

/// Every key of [`FULL`] that the format knows, by its byte range; names of joints are the robot's and any word is one.
fn keys() -> Vec<std::ops::Range<usize>> {
    let bytes = FULL.as_bytes();
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
                let after = FULL[i..].trim_start_matches(' ').as_bytes()[0];
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
    keys.retain(|k| &FULL[k.clone()] != "left_knee");
    keys
}

#[test]
fn the_keys_are_found() {
    let keys: Vec<_> = keys().into_iter().map(|k| &FULL[k]).collect();
    assert!(keys.len() > 60, "{}", keys.len());
    for key in
        ["schema", "robot", "rpy", "polygon", "inertia", "coulomb", "task", "type", "profile", "logspace", "repeat"]
    {
        assert!(keys.contains(&key), "{key}");
    }
    assert_eq!(runs(FULL).len(), 30, "the file itself is sound");
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
        let keys = keys();
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
        // A typo that is itself a key of the format (or a metric, a key of `truth`), or no key at all, is another mistake.
        let known = keys.iter().any(|k| FULL[k.clone()] == typo) || METRICS.contains(&typo.as_str());
        prop_assume!(!typo.is_empty() && !known);
        let text = format!("{}{typo}{}", &FULL[..range.start], &FULL[range.end..]);
        let line = FULL[..range.start].matches('\n').count() + 1;
        match file(&text).and_then(|f| f.expand(&[])) {
            Ok(_) => prop_assert!(false, "`{}` for `{}` on line {} is accepted", typo, key, line),
            Err(found) => {
                let named = found.iter().any(|d| d.place.is_some_and(|p| p.line == line) && d.message.contains(&typo));
                prop_assert!(named, "line {line}, `{typo}`:\n{found}");
            }
        }
    }

    /// Text that is cut, doubled or sprinkled is accepted or refused, and what is refused can be shown.
    #[test]
    fn no_text_makes_it_panic(
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
