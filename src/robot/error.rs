//! Everything that can be wrong with a robot, and how it is shown.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use thiserror::Error;

use super::source::Source;
use crate::text::excerpt::{cut, excerpt};
use crate::text::visible::{visible_lines, visible_path};

/// Why a robot could not be loaded or changed.
#[derive(Clone, Debug, Error)]
pub enum RobotError {
    /// A file cannot be opened or is not text.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// A file is not well-formed TOML or XML.
    #[error("{0}")]
    Syntax(Box<Fault>),
    /// A file is well-formed but says something that makes no robot.
    #[error("{0}")]
    Invalid(Box<Fault>),
    /// A file asks for something this program does not do.
    #[error("{0}")]
    NotAvailable(Box<Fault>),
    /// A name given to one of the functions of [`super::adjust`] is not in the model.
    #[error("the robot has no {kind} `{name}`{}", suggestion.as_ref().map(|s| format!("; did you mean `{s}`?")).unwrap_or_default())]
    UnknownName {
        /// `link` or `joint`.
        kind: &'static str,
        /// The name given.
        name: String,
        /// The nearest name there is.
        suggestion: Option<String>,
    },
    /// A value given to one of the functions of [`super::adjust`] makes no sense.
    #[error("{subject}: {seen}, wanted {wanted}")]
    BadValue {
        /// What the value is about.
        subject: String,
        /// The value given.
        seen: String,
        /// What would have been accepted.
        wanted: String,
    },
}

impl RobotError {
    /// The place in a file, for the variants that have one.
    pub fn fault(&self) -> Option<&Fault> {
        match self {
            RobotError::Syntax(f) | RobotError::Invalid(f) | RobotError::NotAvailable(f) => Some(f),
            _ => None,
        }
    }

    /// A diagnostic for people: message, offending line with a caret, what was wanted. `styled` adds terminal colours.
    pub fn render(&self, styled: bool) -> String {
        let renderer = if styled { Renderer::styled() } else { Renderer::plain() };
        let Some(fault) = self.fault() else {
            return renderer.render(&[Group::with_title(Level::ERROR.primary_title(self.to_string()))]);
        };
        let path = visible_path(fault.file());
        let title = Level::ERROR.primary_title(visible_lines(&fault.message));
        let mut group = match excerpt(fault.source.text(), fault.span.clone()) {
            Some(shown) => {
                let annotation = AnnotationKind::Primary.span(shown.piece).label(fault.label());
                title.element(Snippet::source(shown.text).line_start(shown.line).path(path).annotation(annotation))
            }
            None => title.element(Origin::path(path).line(fault.line()).char_column(fault.column())),
        };
        if let Some(help) = &fault.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        renderer.render(&[group])
    }
}

/// One thing wrong at one place of a file.
#[derive(Clone)]
pub struct Fault {
    /// The file's text.
    pub source: Source,
    /// Byte range in that text.
    pub span: Range<usize>,
    /// What is wrong, one sentence without a full stop.
    pub message: String,
    /// The element it is about, such as `joint l_knee`; empty when the file as a whole.
    pub element: String,
    /// The value found.
    pub seen: String,
    /// What would have been accepted.
    pub wanted: String,
    /// How to get on.
    pub help: Option<String>,
}

impl Fault {
    pub(super) fn new(source: Source, span: Range<usize>, message: String) -> Self {
        let boundary = |at: usize| (0..=at.min(source.text().len())).rev().find(|&i| source.text().is_char_boundary(i));
        let start = boundary(span.start).unwrap_or(0);
        let span = start..boundary(span.end).unwrap_or(0).max(start);
        let none = String::new;
        let message = cut(&message).into_owned();
        Self { source, span, message, element: none(), seen: none(), wanted: none(), help: None }
    }

    pub(super) fn element(mut self, element: impl Into<String>) -> Self {
        self.element = cut(&element.into()).into_owned();
        self
    }

    pub(super) fn seen(mut self, seen: impl fmt::Display) -> Self {
        self.seen = cut(&seen.to_string()).into_owned();
        self
    }

    pub(super) fn wanted(mut self, wanted: impl Into<String>) -> Self {
        self.wanted = cut(&wanted.into()).into_owned();
        self
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(cut(&help.into()).into_owned());
        self
    }

    /// Adds `did you mean` when one of `known` is close to `name`.
    pub(super) fn suggest<'a>(self, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        match nearest(name, known) {
            Some(near) => self.help(format!("did you mean `{near}`?")),
            None => self,
        }
    }

    pub(super) fn syntax(self) -> RobotError {
        RobotError::Syntax(Box::new(self))
    }

    pub(super) fn invalid(self) -> RobotError {
        RobotError::Invalid(Box::new(self))
    }

    pub(super) fn not_available(self) -> RobotError {
        RobotError::NotAvailable(Box::new(self))
    }

    /// The file it is in.
    pub fn file(&self) -> &Path {
        self.source.path()
    }

    /// Line, counted from 1.
    pub fn line(&self) -> usize {
        self.source.position(self.span.start).0
    }

    /// Column in characters, counted from 1.
    pub fn column(&self) -> usize {
        self.source.position(self.span.start).1
    }

    /// The line of the file it points at.
    pub fn source_line(&self) -> &str {
        self.source.text().lines().nth(self.line() - 1).unwrap_or("")
    }

    /// Words under the caret; what was seen is not repeated where the line shows it.
    fn label(&self) -> String {
        let shown = &self.source.text()[self.span.clone()];
        let seen = if shown.contains(self.seen.trim_matches('`')) { "" } else { self.seen.as_str() };
        match (seen, self.wanted.as_str()) {
            ("", "") => "here".into(),
            (seen, "") => seen.into(),
            ("", wanted) => format!("wanted {wanted}"),
            (seen, wanted) => format!("{seen}; wanted {wanted}"),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file().display(), self.line(), self.column(), self.message)?;
        if !self.seen.is_empty() {
            write!(f, ": {}", self.seen)?;
        }
        if !self.wanted.is_empty() {
            write!(f, " (wanted {})", self.wanted)?;
        }
        if let Some(help) = &self.help {
            write!(f, "; {help}")?;
        }
        Ok(())
    }
}

impl fmt::Debug for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// The name of `known` closest to `name`, if close enough to be a slip of the finger; another case counts least.
pub(super) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = name.to_lowercase();
    known
        .into_iter()
        .map(|k| (strsim::damerau_levenshtein(&lower, &k.to_lowercase()), k))
        .filter(|(distance, k)| *distance <= (k.len().max(name.len()) / 3).max(1))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}
