//! Why a run ends before its time.

use super::report::Outcome;

/// An early end: its outcome and words for a person.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct Stop {
    /// Outcome of the run.
    pub outcome: Outcome,
    /// What happened, when and where.
    pub message: String,
}

impl Stop {
    /// An early end.
    pub fn new(outcome: Outcome, message: impl Into<String>) -> Self {
        Stop { outcome, message: message.into() }
    }
}
