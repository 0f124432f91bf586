//! Collects notes and warnings of the loader: ignored elements, assumptions, detected soles.

use std::collections::HashSet;
use std::path::PathBuf;

use crate::text::diagnostic::{Diagnostic, Severity};
use crate::text::source::Source;

/// Notes and warnings about a robot's files, in order of reporting. Equal messages about one file
/// are kept once.
#[derive(Default)]
pub(super) struct Notices {
    all: Vec<Diagnostic>,
    known: HashSet<(PathBuf, String)>,
}

impl Notices {
    /// The notes and warnings.
    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        self.all
    }

    /// Adds a note: an assumption of the loader, or an element without effect that it ignored.
    pub fn info(&mut self, source: &Source, offset: usize, message: impl Into<String>) {
        self.push(Severity::Note, source, offset, message.into());
    }

    /// Adds a warning: the robot may not behave as its author intended.
    pub fn warning(&mut self, source: &Source, offset: usize, message: impl Into<String>) {
        self.push(Severity::Warning, source, offset, message.into());
    }

    fn push(&mut self, severity: Severity, source: &Source, offset: usize, message: String) {
        if self.known.insert((source.path().to_owned(), message.clone())) {
            self.all.push(Diagnostic::in_source(severity, source, offset..offset, message, None));
        }
    }
}
