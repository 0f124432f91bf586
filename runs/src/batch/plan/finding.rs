//! Findings before a batch starts: errors, warnings and notes of scenarios and robots.

use std::collections::HashSet;

use crate::robot::RobotError;
use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity};

/// Number of errors after which checking stops.
pub(super) const MAX_ERRORS: usize = 50;

/// An error, warning or note.
#[derive(Clone, Debug)]
pub enum Finding {
    /// About a scenario file.
    Scenario(Box<Diagnostic>),
    /// A robot that cannot be used.
    Robot {
        /// The error.
        error: Box<RobotError>,
        /// Position in the scenario that names it.
        named_at: String,
    },
    /// About a robot that can be used.
    Notice(Diagnostic),
    /// An error about the batch as a whole.
    Plan(String),
}

impl Finding {
    /// Its severity.
    pub fn severity(&self) -> Severity {
        match self {
            Finding::Scenario(diagnostic) => diagnostic.severity,
            Finding::Notice(notice) => notice.severity,
            Finding::Robot { .. } | Finding::Plan(_) => Severity::Error,
        }
    }

    /// True if its text contains an excerpt of a file.
    pub fn is_block(&self) -> bool {
        matches!(self, Finding::Scenario(_) | Finding::Robot { .. })
    }

    /// Renders it for a terminal, with or without colours; no final newline.
    pub fn render(&self, colour: bool) -> String {
        match self {
            Finding::Scenario(diagnostic) => diagnostic.render(colour),
            Finding::Robot { error, named_at } => {
                format!("{}\n  = note: the robot is named at {named_at}", error.render(colour))
            }
            Finding::Notice(notice) => notice.brief(),
            Finding::Plan(message) => Diagnostic::bare(message, colour),
        }
    }
}

/// Findings in order of discovery, without duplicates.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    list: Vec<Finding>,
    rendered: HashSet<String>,
    errors: usize,
}

impl Findings {
    /// Adds a finding unless an equal one is present.
    pub fn push(&mut self, finding: Finding) {
        if self.rendered.insert(finding.render(false)) {
            self.errors += usize::from(finding.severity() == Severity::Error);
            self.list.push(finding);
        }
    }

    /// Adds all diagnostics of a scenario.
    pub fn extend(&mut self, diagnostics: Diagnostics) {
        for diagnostic in diagnostics.0 {
            self.push(Finding::Scenario(Box::new(diagnostic)));
        }
    }

    /// Iterates in order of discovery.
    pub fn iter(&self) -> std::slice::Iter<'_, Finding> {
        self.list.iter()
    }

    /// Number of errors.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// Number of findings of a severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.list.iter().filter(|f| f.severity() == severity).count()
    }
}
