//! Diagnostics of input files: severity, message, file, line and column, an excerpt with a caret,
//! and help.
//!
//! Scenarios, robot files, URDFs, motions and filters all report their errors as [`Diagnostic`]s,
//! so all render alike.

use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};

use super::excerpt::{excerpt, shorten};
use super::source::{Position, Source, Sources, Span};
use super::toml_syntax;
use super::visible::{visible, visible_lines};

/// How severe a diagnostic is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Severity {
    /// Information: something was ignored, assumed or found.
    Note,
    /// The file can be used, but probably does not mean what its author intended.
    Warning,
    /// The file cannot be used.
    Error,
}

impl Severity {
    /// `note`, `warning` or `error`.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// One error, warning or note about an input file.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// How severe it is.
    pub severity: Severity,
    /// The file as it was named, or `--set` for an override; empty when it is about no file.
    pub file: String,
    /// Position in the file; none when the diagnostic is about the whole file.
    pub position: Option<Position>,
    /// What is wrong, one line.
    pub message: String,
    /// How to correct it.
    pub help: Option<String>,
    /// Text at the caret.
    label: Option<String>,
    /// The text and its marked bytes.
    excerpt: Option<(Source, Range<usize>)>,
}

impl Diagnostic {
    /// A diagnostic about some bytes of a text.
    pub fn in_source(
        severity: Severity,
        source: &Source,
        range: Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> Self {
        let start = source.char_boundary(range.start);
        // One line is shown, however many a table or an array spans.
        let end = source.char_boundary(range.end).min(source.line_end(start)).max(start);
        Diagnostic {
            severity,
            file: source.name(),
            position: Some(source.position(start)),
            message: shorten(&message.into()).into_owned(),
            help: help.map(|help| shorten(&help).into_owned()),
            label: None,
            excerpt: Some((source.clone(), start..end)),
        }
    }

    /// A diagnostic about a span of a scenario's texts.
    pub fn new(
        severity: Severity,
        sources: &Sources,
        span: &Span,
        message: impl Into<String>,
        help: Option<String>,
    ) -> Self {
        match sources.find(span) {
            Some((source, range)) => Self::in_source(severity, &source, range, message, help),
            None => Diagnostic { severity, help, ..Self::whole_file("", message) },
        }
    }

    /// An error about a span of a scenario's texts.
    pub fn error(sources: &Sources, span: &Span, message: impl Into<String>, help: Option<String>) -> Self {
        Self::new(Severity::Error, sources, span, message, help)
    }

    /// An error about some bytes of a text; `file` is its name.
    pub fn in_text(
        file: &str,
        text: &str,
        range: Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> Self {
        Self::in_source(Severity::Error, &Source::new(file, text), range, message, help)
    }

    /// An error about a file as a whole.
    pub fn whole_file(file: impl Into<String>, message: impl Into<String>) -> Self {
        Diagnostic {
            severity: Severity::Error,
            file: file.into(),
            position: None,
            message: shorten(&message.into()).into_owned(),
            help: None,
            label: None,
            excerpt: None,
        }
    }

    /// The same diagnostic with a help line.
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Diagnostic { help: Some(help.into()), ..self }
    }

    /// The same diagnostic with a text at the caret.
    pub fn with_label(self, label: impl Into<String>) -> Self {
        Diagnostic { label: Some(label.into()), ..self }
    }

    /// Renders an error that concerns no file: the first line as its title, the others below.
    pub fn bare(message: &str, colour: bool) -> String {
        let (first, more) = message.split_once('\n').map_or((message, None), |(first, more)| (first, Some(more)));
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let title = renderer.render(&[Group::with_title(Level::ERROR.primary_title(first))]);
        more.map_or(title.clone(), |more| format!("{title}\n{more}"))
    }

    /// Line in the file, from 1; 0 when the diagnostic is about the whole file.
    pub fn line(&self) -> usize {
        self.position.map_or(0, |position| position.line)
    }

    /// `file:line:column`, or the file alone.
    pub fn location(&self) -> String {
        match self.position {
            Some(Position { line, column }) => format!("{}:{line}:{column}", self.file),
            None => self.file.clone(),
        }
    }

    /// The diagnostic on one line, without excerpt and help: `note: file:line: message`.
    pub fn brief(&self) -> String {
        format!("{}: {}:{}: {}", self.severity.name(), self.file, self.line(), self.message)
    }

    /// The source text and the marked bytes of it.
    pub fn marked(&self) -> Option<(&Source, &Range<usize>)> {
        self.excerpt.as_ref().map(|(source, range)| (source, range))
    }

    /// The dotted path of the TOML key at its position, such as `task.0.joints.knee`; none when
    /// there is no key, or the file is not TOML.
    pub fn key(&self) -> Option<String> {
        let (source, range) = self.excerpt.as_ref()?;
        if let Some(path) = toml_syntax::duplicate_key(&self.message) {
            return Some(path.to_owned());
        }
        source.root().path_at(range.start).map(|path| toml_syntax::dotted(&path))
    }

    /// The diagnostic with the marked line and a caret, with terminal colours or without; no
    /// newline at the end.
    pub fn render(&self, colour: bool) -> String {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
            Severity::Note => Level::NOTE,
        };
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let lines = self.excerpt.as_ref().and_then(|(source, range)| excerpt(source, range.clone()));
        // Names of files and keys may contain control characters for terminals.
        let (title, file) = (level.primary_title(visible_lines(&self.message)), visible(&self.file));
        let mut group = match lines {
            Some(lines) => {
                let mark = AnnotationKind::Primary.span(lines.range).label(self.label.as_deref());
                title.element(Snippet::source(lines.text).line_start(lines.line).path(file).annotation(mark))
            }
            None if self.file.is_empty() => Group::with_title(title),
            None => {
                let origin = Origin::path(file);
                title.element(match self.position {
                    Some(Position { line, column }) => origin.line(line).char_column(column),
                    None => origin,
                })
            }
        };
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help));
        }
        renderer.render(&[group])
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostic {}

/// Diagnostics in the order of their positions.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostics {
    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Iterates in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.0.iter()
    }

    /// True when one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.0.iter().any(|d| d.severity == Severity::Error)
    }

    /// Renders all, with an empty line between two.
    pub fn render(&self, colour: bool) -> String {
        self.0.iter().map(|d| d.render(colour)).collect::<Vec<_>>().join("\n\n")
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(one: Diagnostic) -> Self {
        Diagnostics(vec![one])
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostics {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagnostic_has_the_innermost_key_at_its_position() {
        let text = "duration = 1\n[floor]\nfrction = 0.5\n[[task]]\ntype = \"posture\"\njoints = { knee = [1, 2] }\n\
                    [sweep.grid]\n\"floor.friction\" = [0.1,\n-0.2]\n";
        let key = |mark: &str| {
            let at = text.find(mark).unwrap();
            Diagnostic::in_text("s.toml", text, at..at + 1, "", None).key()
        };
        for (mark, expected) in [
            ("duration", "duration"),
            ("= 1", "-"),
            ("1\n", "duration"),
            ("floor]", "floor"),
            ("frction", "floor.frction"),
            ("\"posture", "task.0.type"),
            ("knee", "task.0.joints.knee"),
            ("2]", "task.0.joints.knee.1"),
            ("\"floor.friction", "sweep.grid.\"floor.friction\""),
            ("-0.2", "sweep.grid.\"floor.friction\".1"),
        ] {
            assert_eq!(key(mark).as_deref().unwrap_or("-"), expected, "{mark}");
        }
        assert_eq!(Diagnostic::in_text("x", "no toml", 0..1, "", None).key(), None);
    }
}
