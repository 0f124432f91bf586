//! Collects what a loader ignored, assumed or found: notes and warnings, never errors.

use std::collections::HashSet;
use std::path::PathBuf;

use crate::text::diagnostic::{Diagnostic, Severity};
use crate::text::source::Source;

/// Notes and warnings of a robot's files, in the order in which they came up. An equal message about one file is kept once.
#[derive(Default)]
pub(super) struct Notices {
    all: Vec<Diagnostic>,
    known: HashSet<(PathBuf, String)>,
}

impl Notices {
    /// All of them.
    pub fn into_all(self) -> Vec<Diagnostic> {
        self.all
    }

    /// Adds a choice the loader made, or something without effect that it left out.
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
