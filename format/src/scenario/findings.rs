//! Collection of diagnostics while a scenario is read.

use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::text::source::{Sources, Span};
use crate::text::toml_syntax::TomlError;

/// Errors and warnings of a scenario. At one span only the first finding counts, since later ones
/// follow from it.
#[derive(Default)]
pub struct Findings {
    found: Vec<(Span, Severity, String, Option<String>)>,
    /// Number of errors beyond [`MAX_FINDINGS`].
    more: usize,
}

/// Greatest number of findings kept, each of which is rendered with an excerpt. Further errors are
/// only counted.
const MAX_FINDINGS: usize = 200;

impl Findings {
    /// Adds an error about a span of the sources.
    pub fn error(&mut self, span: Span, message: impl Into<String>, help: Option<String>) {
        self.add(Severity::Error, span, message.into(), help);
    }

    /// Adds a warning about a span of the sources.
    pub fn warning(&mut self, span: Span, message: impl Into<String>, help: Option<String>) {
        self.add(Severity::Warning, span, message.into(), help);
    }

    /// Adds a note about a span of the sources.
    pub fn note(&mut self, span: Span, message: impl Into<String>, help: Option<String>) {
        self.add(Severity::Note, span, message.into(), help);
    }

    /// Adds the syntax errors of a text.
    pub fn syntax(&mut self, errors: Vec<TomlError>) {
        for TomlError { span, message, help } in errors {
            self.error(span, message, help);
        }
    }

    fn add(&mut self, severity: Severity, span: Span, message: String, help: Option<String>) -> bool {
        let new = !self.found.iter().any(|(s, v, _, _)| *s == span && *v >= severity);
        if new && self.found.len() == MAX_FINDINGS {
            self.more += usize::from(severity == Severity::Error);
            return false;
        }
        if new {
            self.found.push((span, severity, message, help));
        }
        new
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.found.is_empty() && self.more == 0
    }

    /// Whether an error was found.
    pub fn has_errors(&self) -> bool {
        self.errors() > 0
    }

    /// Number of errors, with those that are not listed.
    pub fn errors(&self) -> usize {
        self.found.iter().filter(|f| f.1 == Severity::Error).count() + self.more
    }

    /// Adds the findings of another collection; returns those that were new.
    pub fn append(&mut self, other: Findings) -> Findings {
        let mut new = other;
        self.more += std::mem::take(&mut new.more);
        new.found
            .retain(|(span, severity, message, help)| self.add(*severity, span.clone(), message.clone(), help.clone()));
        new
    }

    /// Extends the help of each finding by the text that `more` returns for its span.
    pub fn explain(&mut self, more: impl Fn(&Span) -> Option<String>) {
        for (span, _, _, help) in &mut self.found {
            if let Some(more) = more(span) {
                *help = Some(help.take().map_or_else(|| more.clone(), |help| format!("{help}; {more}")));
            }
        }
    }

    /// The findings in the order of the sources.
    pub fn into_diagnostics(mut self, sources: &Sources) -> Diagnostics {
        self.found.sort_by_key(|f| (f.0.start, f.0.end));
        let shown =
            self.found.into_iter().map(|(span, severity, m, h)| Diagnostic::new(severity, sources, &span, m, h));
        let mut all: Vec<Diagnostic> = shown.collect();
        if let (Some(last), 1..) = (all.last(), self.more) {
            all.push(Diagnostic::whole_file(last.file.clone(), format!("there are {} more errors", self.more)));
        }
        Diagnostics(all)
    }
}
