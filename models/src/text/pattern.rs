//! Matches names against shell patterns.
//!
//! The crate `wildmatch` 2.7 does not replace this: it has no escape character, which `\` is here.

#[derive(Clone, Copy, PartialEq)]
enum Piece {
    /// Any characters: `*`.
    Any,
    /// One character: `?`.
    One,
    /// This character.
    Literal(char),
}

/// True if a name matches a pattern, in which `*` matches any characters and `?` one character. `\`
/// makes the next character literal. The time is at most proportional to the product of both
/// lengths.
pub fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<Piece>, Vec<char>) = (pieces(pattern), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    // Position of the last star, and the end of the characters that it matches.
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        if p < pattern.len() && pattern[p] == Piece::Any {
            star = Some((p, n));
            p += 1;
        } else if p < pattern.len() && (pattern[p] == Piece::One || pattern[p] == Piece::Literal(name[n])) {
            (p, n) = (p + 1, n + 1);
        } else if let Some((at, reach)) = star {
            star = Some((at, reach + 1));
            (p, n) = (at + 1, reach + 1);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|piece| *piece == Piece::Any)
}

fn pieces(pattern: &str) -> Vec<Piece> {
    let mut characters = pattern.chars();
    let piece = || {
        Some(match characters.next()? {
            '*' => Piece::Any,
            '?' => Piece::One,
            // At the end of the pattern it is literal.
            '\\' => Piece::Literal(characters.next().unwrap_or('\\')),
            c => Piece::Literal(c),
        })
    };
    std::iter::from_fn(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_question_marks_and_escapes() {
        let yes = [
            ("*", "a.b"),
            ("", ""),
            ("a*", "a"),
            ("a*c", "abbc"),
            ("*.force_?_N", "sole.left.force_x_N"),
            ("a*b*c", "axxbxbxc"),
            ("?", "é"),
            ("a**", "a"),
            ("*b", "abab"),
            (r"a\*", "a*"),
            (r"\?*", "?x"),
            (r"\\", r"\"),
            (r"a\", r"a\"),
            (r"\a", "a"),
        ];
        let no = [
            ("", "a"),
            ("a", "ab"),
            ("a*c", "abcd"),
            ("?", ""),
            ("*.force_?_N", "force_x_N"),
            ("ab*ab", "ab"),
            (r"a\*", "ab"),
            (r"\?", "a"),
        ];
        assert!(yes.iter().all(|(p, n)| matches(p, n)));
        assert!(no.iter().all(|(p, n)| !matches(p, n)));
    }
}
