//! The lines of a text that a message shows, cut out of it: what draws them goes through all that it is given.

use std::ops::Range;

/// More than this is not shown.
const MOST: usize = 64 << 10;

/// Whole lines of a text with a piece that is marked in them.
#[derive(Debug, PartialEq)]
pub struct Excerpt<'a> {
    /// The lines.
    pub text: &'a str,
    /// Number of the first, from 1.
    pub line: usize,
    /// The piece, bytes of these lines.
    pub piece: Range<usize>,
}

/// The lines on which a piece of a text (bytes, at borders of characters) lies; none if they are too long to be shown.
pub fn excerpt(text: &str, piece: Range<usize>) -> Option<Excerpt<'_>> {
    let start = text[..piece.start].rfind('\n').map_or(0, |at| at + 1);
    let end = text[piece.end..].find('\n').map_or(text.len(), |at| piece.end + at);
    // Lines may end in two characters.
    let end = if end > piece.end && text[..end].ends_with('\r') { end - 1 } else { end };
    if start == end {
        // An empty line, such as that behind the last one: how it is drawn depends on what is around it.
        return (text.len() <= MOST).then_some(Excerpt { text, line: 1, piece });
    }
    let line = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
    let piece = piece.start - start..piece.end - start;
    (end - start <= MOST).then(|| Excerpt { text: &text[start..end], line, piece })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_lines_are_cut_out() {
        let text = "one\ntwo\nthree";
        let shown = |piece| excerpt(text, piece).map(|e| (e.text, e.line, e.piece));
        assert_eq!(shown(4..5), Some(("two", 2, 0..1)));
        assert_eq!(shown(5..9), Some(("two\nthree", 2, 1..5)));
        assert_eq!(shown(13..13), Some(("three", 3, 5..5)));
        assert_eq!(excerpt("a\n\nb", 2..2).map(|e| (e.text, e.line)), Some(("a\n\nb", 1)));
        assert_eq!(excerpt(&"x".repeat(MOST + 1), 3..4), None);
    }
}
