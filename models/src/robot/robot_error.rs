//! Errors of robot files and URDFs, and of changes to a loaded robot.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::input;
use crate::text::diagnostic::{Diagnostic, Severity};
use crate::text::excerpt::shorten;
use crate::text::source::{Position, Source};
use crate::text::suggest::nearest;

/// Why a robot could not be loaded or changed.
#[derive(Clone, Debug, Error)]
pub enum RobotError {
    /// A file cannot be opened or is not text.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's message.
        reason: String,
    },
    /// A file is not well-formed TOML or XML.
    #[error("{0}")]
    Syntax(Box<FileError>),
    /// A file is well-formed but its content describes no valid robot.
    #[error("{0}")]
    Invalid(Box<FileError>),
    /// A file requires a feature that this program does not have.
    #[error("{0}")]
    NotAvailable(Box<FileError>),
    /// A name given to one of the functions of [`super::adjustments`] is not in the model.
    #[error("the robot has no {kind} `{name}`{}", suggestion.as_ref().map(|s| format!("; did you mean `{s}`?")).unwrap_or_default())]
    UnknownName {
        /// `link` or `joint`.
        kind: &'static str,
        /// The name given.
        name: String,
        /// The nearest name there is.
        suggestion: Option<String>,
    },
    /// A value given to one of the functions of [`super::adjustments`] is not valid.
    #[error("{subject}: {found}, expected {expected}")]
    BadValue {
        /// Name of the value.
        subject: String,
        /// The value given.
        found: String,
        /// Description of accepted values.
        expected: String,
    },
}

impl RobotError {
    /// The error in a file, for the variants that have one.
    pub fn file_error(&self) -> Option<&FileError> {
        match self {
            RobotError::Syntax(error) | RobotError::Invalid(error) | RobotError::NotAvailable(error) => Some(error),
            _ => None,
        }
    }

    /// The error with its excerpt, if it has a position in a file.
    pub fn diagnostic(&self) -> Diagnostic {
        self.file_error().map_or_else(|| Diagnostic::whole_file("", self.to_string()), FileError::diagnostic)
    }

    /// Renders the diagnostic; `styled` adds terminal colours.
    pub fn render(&self, styled: bool) -> String {
        self.diagnostic().render(styled)
    }
}

/// Reads a robot file or URDF; [`RobotError::Read`] when it cannot be opened or is not UTF-8.
pub(super) fn read_source(path: &Path) -> Result<Source, RobotError> {
    let text = input::read_text(path, input::MOST_TEXT)
        .map_err(|source| RobotError::Read { path: path.to_owned(), reason: source.to_string() })?;
    Ok(Source::new(path, text))
}

/// An error at one position of a robot file or URDF.
#[derive(Clone)]
pub struct FileError {
    /// The file's text.
    pub source: Source,
    /// Byte range in that text.
    pub span: Range<usize>,
    /// What is wrong, one sentence without a full stop.
    pub message: String,
    /// The element it is about, such as `joint l_knee`; empty for the whole file.
    pub element: String,
    /// The value found.
    pub found: String,
    /// Description of accepted values.
    pub expected: String,
    /// How to correct it.
    pub help: Option<String>,
}

impl FileError {
    /// An error at `span`; the methods below add element, value found and expected value.
    pub(super) fn new(source: &Source, span: Range<usize>, message: impl Into<String>) -> Self {
        let start = source.char_boundary(span.start);
        let span = start..source.char_boundary(span.end).max(start);
        let message = shorten(&message.into()).into_owned();
        let none = String::new;
        Self { source: source.clone(), span, message, element: none(), found: none(), expected: none(), help: None }
    }

    pub(super) fn element(mut self, element: impl Into<String>) -> Self {
        self.element = shorten(&element.into()).into_owned();
        self
    }

    pub(super) fn found(mut self, found: impl fmt::Display) -> Self {
        self.found = shorten(&found.to_string()).into_owned();
        self
    }

    pub(super) fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = shorten(&expected.into()).into_owned();
        self
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(shorten(&help.into()).into_owned());
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

    /// The error as a diagnostic with an excerpt.
    pub fn diagnostic(&self) -> Diagnostic {
        let message = self.message.as_str();
        let diagnostic =
            Diagnostic::in_source(Severity::Error, &self.source, self.span.clone(), message, self.help.clone());
        diagnostic.with_label(self.label())
    }

    /// Text at the caret. The value found is not repeated where the line shows it.
    fn label(&self) -> String {
        let shown = &self.source.text()[self.span.clone()];
        let found = if shown.contains(self.found.trim_matches('`')) { "" } else { self.found.as_str() };
        match (found, self.expected.as_str()) {
            ("", "") => "here".into(),
            (found, "") => found.into(),
            ("", expected) => format!("expected {expected}"),
            (found, expected) => format!("{found}; expected {expected}"),
        }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Position { line, column } = self.source.position(self.span.start);
        write!(f, "{}:{line}:{column}: {}", self.source.name(), self.message)?;
        if !self.found.is_empty() {
            write!(f, ": {}", self.found)?;
        }
        if !self.expected.is_empty() {
            write!(f, " (expected {})", self.expected)?;
        }
        if let Some(help) = &self.help {
            write!(f, "; {help}")?;
        }
        Ok(())
    }
}

impl fmt::Debug for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}
