//! Excerpts of a text for messages: the lines that a message concerns, and long words shortened.
//!
//! Only these lines are given to the renderer, whose cost grows with the text it receives.

use std::borrow::Cow;
use std::ops::Range;

use super::source::Source;

/// Longest excerpt, bytes.
const MAX_LENGTH: usize = 64 << 10;

/// Whole lines of a text with a marked range.
#[derive(Debug, PartialEq)]
pub struct Excerpt<'a> {
    /// The lines.
    pub text: &'a str,
    /// Number of the first, from 1.
    pub line: usize,
    /// The marked range, bytes of these lines.
    pub range: Range<usize>,
}

/// The lines of a range of a text (bytes, at character boundaries); none if they are too long.
pub fn excerpt(source: &Source, range: Range<usize>) -> Option<Excerpt<'_>> {
    let text = source.text();
    let (line, start, end) = (source.line(range.start), source.line_start(range.start), source.line_end(range.end));
    // Lines may end in "\r\n".
    let end = if end > range.end && text[..end].ends_with('\r') { end - 1 } else { end };
    if start == end {
        // An empty line, such as that after the last one, is rendered correctly only with the lines
        // around it.
        return (text.len() <= MAX_LENGTH).then_some(Excerpt { text, line: 1, range });
    }
    let range = range.start - start..range.end - start;
    (end - start <= MAX_LENGTH).then(|| Excerpt { text: &text[start..end], line, range })
}

/// Characters kept at the beginning and end of a long word of a message; together more than usual
/// names and paths have.
const WORD_ENDS: (usize, usize) = (300, 100);
/// The same for a whole message.
const MESSAGE_ENDS: (usize, usize) = (6000, 1000);

/// A message with long words, such as a key of megabytes, shortened in their middle.
pub fn shorten(message: &str) -> Cow<'_, str> {
    if message.len() <= WORD_ENDS.0 + WORD_ENDS.1 {
        return message.into();
    }
    let words: Vec<Cow<'_, str>> = message.split(' ').map(|word| shorten_middle(word, WORD_ENDS)).collect();
    shorten_middle(&words.join(" "), MESSAGE_ENDS).into_owned().into()
}

/// Leaves out the middle of a text with more characters than `first + last`.
pub(super) fn shorten_middle(text: &str, (first, last): (usize, usize)) -> Cow<'_, str> {
    if text.len() <= first + last {
        return text.into();
    }
    let boundary = |nth: usize| text.char_indices().nth(nth).map(|(at, _)| at);
    let end = text.char_indices().nth_back(last - 1).map(|(at, _)| at);
    match (boundary(first), end) {
        (Some(start), Some(end)) if start < end => format!("{}…{}", &text[..start], &text[end..]).into(),
        _ => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_words_of_a_message_are_shortened_in_their_middle() {
        let long = "é".repeat(WORD_ENDS.0 + WORD_ENDS.1 + 1);
        let shown = shorten(&format!("unknown key `{long}` in `floor`")).into_owned();
        assert_eq!(
            shown.chars().filter(|c| *c == 'é').count(),
            WORD_ENDS.0 + WORD_ENDS.1 - 2,
            "without the two quotes"
        );
        assert!(shown.starts_with("unknown key `éé") && shown.contains("é…é") && shown.ends_with("é` in `floor`"));
        let short = "é".repeat(WORD_ENDS.0 + WORD_ENDS.1 - 2);
        assert_eq!(shorten(&format!("`{short}`")), format!("`{short}`"));
        let many = "two words ".repeat(10_000);
        assert_eq!(shorten(&many).chars().count(), MESSAGE_ENDS.0 + MESSAGE_ENDS.1 + 1);
    }

    #[test]
    fn whole_lines_are_cut_out() {
        let text = "one\ntwo\nthree";
        let shown =
            |text: &str, range| excerpt(&Source::new("", text), range).map(|e| (e.text.to_owned(), e.line, e.range));
        assert_eq!(shown(text, 4..5), Some(("two".into(), 2, 0..1)));
        assert_eq!(shown(text, 5..9), Some(("two\nthree".into(), 2, 1..5)));
        assert_eq!(shown(text, 13..13), Some(("three".into(), 3, 5..5)));
        assert_eq!(shown("a\r\nb", 0..1), Some(("a".into(), 1, 0..1)));
        assert_eq!(shown("a\n\nb", 2..2), Some(("a\n\nb".into(), 1, 2..2)));
        assert_eq!(shown(&"x".repeat(MAX_LENGTH + 1), 3..4), None);
    }
}
