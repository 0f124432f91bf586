//! End of a simulation, before its expectations are evaluated.

use crate::files::RecordError;
use crate::results::{Comparison, ReferenceMotion};
use crate::sim::{AvoidanceTime, Metrics, Outcome};
use crate::text::length_limit::limit_length;

/// End of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct RunEnd {
    /// Outcome before expectations are evaluated.
    pub outcome: Outcome,
    /// The reason; may be empty.
    pub message: String,
    /// Metrics; none if nothing was measured.
    pub metrics: Option<Metrics>,
    /// Additional notes.
    pub notes: Vec<String>,
    /// Differences from its reference.
    pub comparison: Comparison,
    /// Its motion, if requested.
    pub trajectory: Option<ReferenceMotion>,
    /// Processor time of self-collision avoidance.
    pub avoidance: Option<AvoidanceTime>,
    /// True if a file could not be written because the disk or a quota is full.
    pub storage_full: bool,
}

impl RunEnd {
    /// An end by an error.
    pub fn error(message: impl Into<String>) -> Self {
        Self { message: limit_length(message.into()), ..Self::of(Outcome::Error) }
    }

    /// An end because a file cannot be written.
    pub fn of_unwritten(error: &RecordError) -> Self {
        Self { storage_full: error.is_storage_full(), ..Self::error(error.to_string()) }
    }

    /// An end with this outcome and no further data.
    pub fn of(outcome: Outcome) -> Self {
        Self {
            outcome,
            message: String::new(),
            metrics: None,
            notes: Vec::new(),
            comparison: Comparison::default(),
            trajectory: None,
            avoidance: None,
            storage_full: false,
        }
    }
}
