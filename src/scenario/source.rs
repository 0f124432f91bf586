//! Texts that values come from, laid end to end so that one number names a byte in any of them.
//!
//! A scenario is the sum of its file and of the overrides given beside it. Every value of it remembers a [`Span`] in
//! this common space, and whatever is wrong with it later is shown where it was written.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::diagnostic::Findings;
use super::tree::Node;

/// A byte range in the common space of all [`Sources`].
pub type Span = Range<usize>;

/// One text with the name it is shown under.
#[derive(Debug)]
pub struct Source {
    /// Path of a file, or `--set` for an override.
    pub name: String,
    /// The whole text.
    pub text: String,
    root: OnceLock<Node>,
}

impl Source {
    /// A text.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Source { name: name.into(), text: text.into(), root: OnceLock::new() }
    }

    /// The text as TOML, its spans its own; read once, however many diagnostics ask.
    pub fn root(&self) -> &Node {
        self.root.get_or_init(|| Node::parse(&self.text, 0, &mut Findings::default()))
    }
}

/// The texts of one scenario. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    texts: Vec<(usize, Arc<Source>)>,
}

impl Sources {
    /// Append a text; returns where it starts in the common space.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> usize {
        let start = self.end();
        self.texts.push((start, Arc::new(Source::new(name, text))));
        start
    }

    // One byte of room behind each text, so that a span at its end is not at the next one's start.
    fn end(&self) -> usize {
        self.texts.last().map_or(0, |(start, source)| start + source.text.len() + 1)
    }

    /// The text that holds a span, and the span inside that text.
    pub fn find(&self, span: &Span) -> Option<(Arc<Source>, Range<usize>)> {
        let (start, source) = self.texts.iter().rev().find(|(start, _)| *start <= span.start)?;
        let clip = |at: usize| floor_char_boundary(&source.text, (at - start).min(source.text.len()));
        Some((source.clone(), clip(span.start)..clip(span.end.max(span.start))))
    }

    /// The written text of a span.
    pub fn slice(&self, span: &Span) -> String {
        self.find(span).map_or_else(String::new, |(source, range)| source.text[range].to_owned())
    }
}

/// Line and column, both from 1, columns in characters, of a byte in a text.
pub fn line_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..floor_char_boundary(text, byte.min(text.len()))];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

fn floor_char_boundary(text: &str, mut byte: usize) -> usize {
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_lead_back_to_their_own_text() {
        let mut sources = Sources::default();
        let a = sources.add("a", "xy");
        let b = sources.add("b", "é = 1");
        let name = |span: Span| sources.find(&span).map(|(s, r)| (s.name.clone(), r));
        assert_eq!(name(a..a + 2), Some(("a".into(), 0..2)));
        assert_eq!(name(a + 2..a + 2), Some(("a".into(), 2..2)), "the end of a text still belongs to it");
        assert_eq!(name(b + 5..b + 6), Some(("b".into(), 5..6)));
        assert_eq!(name(b + 1..b + 2), Some(("b".into(), 0..2)), "never inside a character");
    }

    #[test]
    fn columns_count_characters() {
        assert_eq!(line_column("ab\néx", 3), (2, 1));
        assert_eq!(line_column("ab\néx", 5), (2, 2));
        assert_eq!(line_column("ab\n", 99), (2, 1));
    }
}
