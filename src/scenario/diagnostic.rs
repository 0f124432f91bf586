//! What is wrong with a scenario, shown with file, line, column, the line itself and a caret.

use std::{fmt, ops::Range, sync::Arc};

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use super::source::{Source, Sources, Span, line_column};
use crate::text::excerpt::{cut, excerpt};
use crate::text::visible::{visible, visible_lines};

/// How bad it is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Severity {
    /// The scenario cannot run.
    Error,
    /// It runs, but probably not as meant.
    Warning,
}

/// Where in a text, both numbers from 1.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Place {
    /// Line.
    pub line: usize,
    /// Column, in characters.
    pub column: usize,
}

/// One thing that is wrong.
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// The file as it was named, or `--set` for an override.
    pub file: String,
    /// Where; none when the file could not even be read.
    pub place: Option<Place>,
    /// What is wrong, one line.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    pub(super) snippet: Option<(Arc<Source>, Range<usize>)>,
}

impl Diagnostic {
    pub(super) fn new(
        severity: Severity,
        sources: &Sources,
        span: &Span,
        message: impl Into<String>,
        help: Option<String>,
    ) -> Self {
        let snippet = sources.find(span).map(|(source, range)| {
            // One line is shown, however far a table or an array reaches.
            let line_end = source.text[range.start..].find('\n').map_or(source.text.len(), |n| range.start + n);
            let end = range.end.min(line_end).max(range.start);
            (source, range.start..end)
        });
        let (file, place) = match &snippet {
            Some((source, range)) => {
                let (line, column) = line_column(&source.text, range.start);
                (source.name.clone(), Some(Place { line, column }))
            }
            None => (String::new(), None),
        };
        let message = cut(&message.into()).into_owned();
        let help = help.map(|help| cut(&help).into_owned());
        Diagnostic { severity, file, place, message, help, snippet }
    }

    pub(super) fn error(sources: &Sources, span: &Span, message: impl Into<String>, help: Option<String>) -> Self {
        Self::new(Severity::Error, sources, span, message, help)
    }

    /// An error about a piece (bytes) of a text that is no scenario's; `file` is what it is called.
    pub fn in_text(
        file: &str,
        text: &str,
        piece: Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> Self {
        let mut sources = Sources::default();
        let start = sources.add(file, text);
        Self::error(&sources, &(start + piece.start..start + piece.end), message, help)
    }

    /// An error about a file as a whole.
    pub fn unreadable(file: impl Into<String>, message: impl Into<String>) -> Self {
        Diagnostic {
            severity: Severity::Error,
            file: file.into(),
            place: None,
            message: cut(&message.into()).into_owned(),
            help: None,
            snippet: None,
        }
    }

    /// It with what to do about it.
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Diagnostic { help: Some(help.into()), ..self }
    }

    /// An error that is about no file, in the same form and colours: what is wrong in its first line, more below.
    pub fn bare(message: &str, colour: bool) -> String {
        let (first, more) = message.split_once('\n').map_or((message, None), |(first, more)| (first, Some(more)));
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let title = renderer.render(&[Group::with_title(Level::ERROR.primary_title(first))]);
        more.map_or(title.clone(), |more| format!("{title}\n{more}"))
    }

    /// `file:line:column`, or the file alone.
    pub fn location(&self) -> String {
        match self.place {
            Some(Place { line, column }) => format!("{}:{line}:{column}", self.file),
            None => self.file.clone(),
        }
    }

    /// The diagnostic as a compiler shows it, with terminal colours or without; no newline at the end.
    pub fn render(&self, colour: bool) -> String {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let shown = self.snippet.as_ref().and_then(|(source, range)| excerpt(&source.text, range.clone()));
        let is_shown = shown.is_some();
        // Names of files and keys may have what a terminal would obey.
        let (message, file) = (visible_lines(&self.message), visible(&self.file));
        let mut group = level.primary_title(message).elements(shown.map(|shown| {
            let mark = AnnotationKind::Primary.span(shown.piece);
            Snippet::source(shown.text).line_start(shown.line).path(file.clone()).annotation(mark)
        }));
        if !is_shown {
            let origin = annotate_snippets::Origin::path(file.clone());
            group = group.element(match self.place {
                Some(Place { line, column }) => origin.line(line).char_column(column),
                None => origin,
            });
        }
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

/// One or more [`Diagnostic`]s, in the order of their places.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostics {
    /// Are there none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// In order.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.0.iter()
    }

    /// Is there an error among them.
    pub fn has_errors(&self) -> bool {
        self.0.iter().any(|d| d.severity == Severity::Error)
    }

    /// All of them as a compiler shows them, an empty line between two.
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

/// Collects what is wrong while a scenario is read: at one place only the first finding counts, since later ones
/// follow from it.
#[derive(Default)]
pub struct Findings {
    found: Vec<(Span, Severity, String, Option<String>)>,
    /// Errors beyond the most that are kept.
    more: usize,
}

/// Findings that are kept: each is shown in its file, and nobody reads so many.
const MOST_FOUND: usize = 200;

impl Findings {
    pub fn error(&mut self, span: Span, message: impl Into<String>, help: Option<String>) {
        self.add(Severity::Error, span, message.into(), help);
    }

    pub fn warning(&mut self, span: Span, message: impl Into<String>, help: Option<String>) {
        self.add(Severity::Warning, span, message.into(), help);
    }

    fn add(&mut self, severity: Severity, span: Span, message: String, help: Option<String>) -> bool {
        let new = !self.found.iter().any(|(s, v, _, _)| *s == span && *v <= severity);
        if new && self.found.len() == MOST_FOUND {
            self.more += usize::from(severity == Severity::Error);
            return false;
        }
        if new {
            self.found.push((span, severity, message, help));
        }
        new
    }

    pub fn has_errors(&self) -> bool {
        self.errors() > 0
    }

    pub fn errors(&self) -> usize {
        self.found.iter().filter(|f| f.1 == Severity::Error).count() + self.more
    }

    /// Take over all of another's; what was not known before is returned too.
    pub fn append(&mut self, other: Findings) -> Findings {
        let mut new = other;
        self.more += std::mem::take(&mut new.more);
        new.found
            .retain(|(span, severity, message, help)| self.add(*severity, span.clone(), message.clone(), help.clone()));
        new
    }

    /// Adds to the help of what stands at a place what there is to say about that place.
    pub fn explain(&mut self, more: impl Fn(&Span) -> Option<String>) {
        for (span, _, _, help) in &mut self.found {
            if let Some(more) = more(span) {
                *help = Some(help.take().map_or_else(|| more.clone(), |help| format!("{help}; {more}")));
            }
        }
    }

    pub fn into_diagnostics(mut self, sources: &Sources) -> Diagnostics {
        self.found.sort_by_key(|f| (f.0.start, f.0.end));
        let shown =
            self.found.into_iter().map(|(span, severity, m, h)| Diagnostic::new(severity, sources, &span, m, h));
        let mut all: Vec<Diagnostic> = shown.collect();
        if let (Some(last), 1..) = (all.last(), self.more) {
            all.push(Diagnostic::unreadable(last.file.clone(), format!("there are {} more errors", self.more)));
        }
        Diagnostics(all)
    }
}
