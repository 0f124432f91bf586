//! End of a simulation, before its expectations are evaluated.

use crate::results::{Comparison, ReferenceMotion};
use crate::sim::{AvoidanceTime, Metrics, Outcome};

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
}

impl RunEnd {
    /// An end by an error.
    pub fn error(message: impl Into<String>) -> Self {
        Self { message: message.into(), ..Self::of(Outcome::Error) }
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
        }
    }
}
