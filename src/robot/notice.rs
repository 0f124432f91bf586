//! What a loader ignored, assumed or found: never an error, never silent.

use std::collections::HashSet;
use std::fmt;
use std::path::PathBuf;

use super::source::Source;

/// How much a notice matters.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Severity {
    /// A choice the loader made, or something of no effect that was left out.
    Info,
    /// The robot may not behave as its author meant.
    Warning,
}

/// Something ignored, assumed or found while loading.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Notice {
    /// How much it matters.
    pub severity: Severity,
    /// The file it is about.
    pub file: PathBuf,
    /// Line in that file, counted from 1.
    pub line: usize,
    /// What was ignored, assumed or found.
    pub message: String,
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match self.severity {
            Severity::Info => "note",
            Severity::Warning => "warning",
        };
        write!(f, "{word}: {}:{}: {}", self.file.display(), self.line, self.message)
    }
}

/// Collects notices while a file is read.
#[derive(Default)]
pub(super) struct Notices {
    all: Vec<Notice>,
    /// What was told of which file.
    told: HashSet<(PathBuf, String)>,
}

impl Notices {
    /// In the order in which they came up.
    pub fn into_all(self) -> Vec<Notice> {
        self.all
    }

    pub fn info(&mut self, source: &Source, offset: usize, message: impl Into<String>) {
        self.push(Severity::Info, source, offset, message.into());
    }

    pub fn warning(&mut self, source: &Source, offset: usize, message: impl Into<String>) {
        self.push(Severity::Warning, source, offset, message.into());
    }

    /// Equal messages are told once, where they came up first.
    fn push(&mut self, severity: Severity, source: &Source, offset: usize, message: String) {
        if self.told.insert((source.path().to_owned(), message.clone())) {
            self.all.push(Notice { severity, file: source.path().to_owned(), line: source.line(offset), message });
        }
    }
}
