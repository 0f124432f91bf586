//! Errors that end a run early.

use super::report::Outcome;
use crate::text::length_limit::limit_length;
use std::fmt::Display;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why a run ended early: its outcome and a message.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct RunError {
    /// Outcome of the run.
    pub outcome: Outcome,
    /// What happened, where and when.
    pub message: String,
}

impl RunError {
    /// An early end with this outcome. A long message is [shortened](limit_length).
    pub fn new(outcome: Outcome, message: impl Into<String>) -> Self {
        RunError { outcome, message: limit_length(message.into()) }
    }

    /// An early end with outcome `error`.
    pub fn internal(cause: impl Display) -> Self {
        RunError::new(Outcome::Error, cause.to_string())
    }

    /// The outcome's name and the message.
    pub fn with_outcome(&self) -> String {
        match self.message.as_str() {
            "" => self.outcome.name().to_owned(),
            message => format!("{}: {message}", self.outcome.name()),
        }
    }

    /// Outcome and message of a run. After an interruption the outcome is `cancelled`, whatever
    /// error a script or link reported because of it.
    pub fn outcome_of(end: Result<(), RunError>, cancel: &AtomicBool) -> (Outcome, String) {
        match end {
            Ok(()) => (Outcome::Passed, String::new()),
            Err(_) if cancel.load(Ordering::Relaxed) => (Outcome::Cancelled, "interrupted".to_owned()),
            Err(error) => (error.outcome, error.message),
        }
    }
}
