//! What the dispatcher is told, in the order in which it happened.

use std::sync::Arc;
use std::time::Instant;

use super::{Cancellation, Finished};

/// Something that happened in a batch.
pub(super) enum Event {
    /// A run began.
    Started {
        /// Its position in the plan.
        index: usize,
        /// When.
        at: Instant,
        /// Ends it.
        cancellation: Arc<Cancellation>,
    },
    /// A run ended and its files are written.
    Finished {
        /// Its position in the plan.
        index: usize,
        /// What it came to.
        finished: Box<Finished>,
    },
    /// A person wants the batch to end.
    Interrupt,
    /// No thread works any more.
    Drained,
}
