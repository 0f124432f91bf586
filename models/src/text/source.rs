//! Source texts with positions: bytes to lines and columns, and several texts in one common space.
//!
//! A scenario is the sum of its file and of the overrides on the command line. Every value
//! remembers a [`Span`] in the common space of all its [`Sources`], so an error that is found later
//! is shown where the value was written.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use super::toml_tree::Node;

/// A byte range in the common space of all [`Sources`].
pub type Span = Range<usize>;

/// Line and column in a text, both from 1.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Position {
    /// Line.
    pub line: usize,
    /// Column, in characters.
    pub column: usize,
}

/// One text with the path it is shown under. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Source(Arc<Text>);

#[derive(Debug)]
struct Text {
    path: PathBuf,
    text: String,
    /// Byte offsets at which lines begin, ascending from 0.
    lines: OnceLock<Vec<usize>>,
    root: OnceLock<Node>,
}

impl Source {
    /// A text; `path` is that of its file, or a name such as `--set` for an override.
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        let (lines, root) = (OnceLock::new(), OnceLock::new());
        Source(Arc::new(Text { path: path.into(), text: text.into(), lines, root }))
    }

    /// The path as it was given.
    pub fn path(&self) -> &Path {
        &self.0.path
    }

    /// The path as it is shown.
    pub fn name(&self) -> String {
        self.0.path.display().to_string()
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.0.text
    }

    /// The text as TOML, parsed once; its spans are bytes of this text.
    pub fn root(&self) -> &Node {
        self.0.root.get_or_init(|| Node::parse(&self.0.text, 0).0)
    }

    /// Position of a byte. A byte inside a character or beyond the end counts as the nearest one
    /// before it.
    pub fn position(&self, byte: usize) -> Position {
        let byte = self.char_boundary(byte);
        let line = self.line(byte);
        let column = self.0.text[self.line_start(byte)..byte].chars().count() + 1;
        Position { line, column }
    }

    /// Line of a byte, from 1.
    pub fn line(&self, byte: usize) -> usize {
        self.lines().partition_point(|start| *start <= byte.min(self.0.text.len()))
    }

    /// Where the line of a byte starts.
    pub fn line_start(&self, byte: usize) -> usize {
        self.lines()[self.line(byte) - 1]
    }

    /// Where the line of a byte ends, without its `\n`.
    pub fn line_end(&self, byte: usize) -> usize {
        self.lines().get(self.line(byte)).map_or(self.0.text.len(), |next| next - 1)
    }

    /// The nearest character boundary at or before a byte.
    pub fn char_boundary(&self, byte: usize) -> usize {
        self.0.text.floor_char_boundary(byte)
    }

    fn lines(&self) -> &[usize] {
        let starts = || std::iter::once(0).chain(self.0.text.match_indices('\n').map(|(i, _)| i + 1)).collect();
        self.0.lines.get_or_init(starts)
    }
}

/// The texts of one scenario. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    texts: Vec<(usize, Source)>,
}

impl Sources {
    /// Appends a text; returns its start in the common space.
    pub fn add(&mut self, path: impl Into<PathBuf>, text: impl Into<String>) -> usize {
        let start = self.end();
        self.texts.push((start, Source::new(path, text)));
        start
    }

    // One byte between texts, so that the end of one is not the start of the next.
    fn end(&self) -> usize {
        self.texts.last().map_or(0, |(start, source)| start + source.text().len() + 1)
    }

    /// The text that holds a span, and the span inside that text.
    pub fn find(&self, span: &Span) -> Option<(Source, Range<usize>)> {
        let (start, source) = self.texts.iter().rev().find(|(start, _)| *start <= span.start)?;
        let clip = |at: usize| source.char_boundary(at - start);
        Some((source.clone(), clip(span.start)..clip(span.end.max(span.start))))
    }

    /// The written text of a span.
    pub fn slice(&self, span: &Span) -> String {
        self.find(span).map_or_else(String::new, |(source, range)| source.text()[range].to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_belongs_to_the_text_that_holds_it() {
        let mut sources = Sources::default();
        let a = sources.add("a", "xy");
        let b = sources.add("b", "é = 1");
        let name = |span: Span| sources.find(&span).map(|(s, r)| (s.name(), r));
        assert_eq!(name(a..a + 2), Some(("a".into(), 0..2)));
        assert_eq!(name(a + 2..a + 2), Some(("a".into(), 2..2)), "the end of a text still belongs to it");
        assert_eq!(name(b + 5..b + 6), Some(("b".into(), 5..6)));
        assert_eq!(name(b + 1..b + 2), Some(("b".into(), 0..2)), "never inside a character");
    }

    #[test]
    fn columns_count_characters() {
        let at = |text: &str, byte| {
            let Position { line, column } = Source::new("", text).position(byte);
            (line, column)
        };
        assert_eq!(at("ab\néx", 3), (2, 1));
        assert_eq!(at("ab\néx", 5), (2, 2));
        assert_eq!(at("ab\n", 99), (2, 1));
    }
}
