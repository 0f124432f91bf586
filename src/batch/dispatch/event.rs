//! What the dispatcher is told, in the order in which it happened.

use std::sync::Arc;
use std::time::Instant;

use crate::batch::run::run_timer::Lap;
use crate::batch::{Cancellation, Finished, Job};

/// Something that is done, by its position in the plan.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(in crate::batch) enum Work {
    /// A run that others are compared with.
    Reference(usize),
    /// A run.
    Run(usize),
    /// A repetition of a run, to time it.
    Repetition(usize),
}

/// Something that happened in a batch.
pub(in crate::batch) enum Event {
    /// Work began.
    Started {
        /// Which.
        work: Work,
        /// The run; none for a repetition.
        job: Option<Arc<Job>>,
        /// When.
        at: Instant,
        /// Ends it.
        cancellation: Arc<Cancellation>,
    },
    /// A run ended and its files are written.
    Finished {
        /// Which.
        work: Work,
        /// What it came to.
        finished: Box<Finished>,
    },
    /// A round of repetitions begins.
    Round {
        /// Which, from 1.
        round: u32,
        /// Of how many.
        rounds: u32,
        /// Repetitions in it.
        runs: usize,
    },
    /// A repetition ended.
    Timed {
        /// The run's position in the plan.
        index: usize,
        /// Its times, or why there are none.
        lap: Result<Lap, String>,
    },
    /// A person wants the batch to end.
    Interrupt,
    /// No thread works any more.
    Drained,
}
