//! Why a run ends before its time.

use super::report::Outcome;
use std::sync::atomic::{AtomicBool, Ordering};

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
    /// The outcome of a run that ended so, with its words. One that was ended from outside is no fault of its own, whatever a
    /// script or a link made of that.
    pub fn outcome_of(end: Result<(), Stop>, cancel: &AtomicBool) -> (Outcome, String) {
        match end {
            Ok(()) => (Outcome::Passed, String::new()),
            Err(_) if cancel.load(Ordering::Relaxed) => (Outcome::Cancelled, "interrupted".to_owned()),
            Err(stop) => (stop.outcome, stop.message),
        }
    }

    /// An early end.
    pub fn new(outcome: Outcome, message: impl Into<String>) -> Self {
        Stop { outcome, message: message.into() }
    }
}
