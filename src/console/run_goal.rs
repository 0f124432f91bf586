//! Target of a run: a control tick, or an event before it.

use std::fmt::{Display, Formatter, Result as FmtResult};

/// Event kinds that a run can wait for.
pub const EVENT_KINDS: &[&str] = &[
    "touchdown",
    "liftoff",
    "slip",
    "stick",
    "state",
    "turning",
    "border",
    "forced",
    "impact",
    "jam",
    "sliding-mode",
    "inconsistent",
    "self-collision",
    "task",
    "event",
    "force",
    "push",
    "spring",
    "object",
];

/// Target of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunGoal {
    /// Control tick at which to stop.
    pub tick: u64,
    /// Control rate, Hz.
    pub rate: f64,
    /// Event that stops the run earlier: kind and subject.
    pub event: Option<(String, Option<String>)>,
    /// Number of events before the run.
    pub since: u64,
}

impl Display for RunGoal {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        match &self.event {
            Some((kind, Some(subject))) => write!(f, "{kind} {subject}"),
            Some((kind, None)) => write!(f, "{kind}"),
            None => write!(f, "{} s", self.tick as f64 / self.rate),
        }
    }
}
