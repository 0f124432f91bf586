//! Events that worker threads send to the dispatcher.

use std::sync::Arc;
use std::time::Instant;

use crate::files::RecordError;
use crate::sim::RunError;

use crate::batch::run::run_timer::Lap;
use crate::batch::{Cancellation, Finished, Job};

/// A unit of work, by its position in the plan.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(in crate::batch) enum Work {
    /// A run that others are compared with.
    Reference(usize),
    /// A run.
    Run(usize),
    /// A repetition of a run, to time it.
    Repetition(usize),
}

/// An event of a batch.
pub(in crate::batch) enum Event {
    /// Work began.
    Started {
        /// The work.
        work: Work,
        /// The run; none for a repetition.
        job: Option<Arc<Job>>,
        /// Start time.
        at: Instant,
        /// Cancels the work.
        cancellation: Arc<Cancellation>,
    },
    /// A run ended and its files are written; if it is no reference, its line of `runs.jsonl` too.
    Finished {
        /// The work.
        work: Work,
        /// Its result.
        finished: Box<Finished>,
        /// Why its line could not be written.
        unlisted: Option<RecordError>,
    },
    /// A round of repetitions begins.
    Round {
        /// Its number, from 1.
        round: u32,
        /// Number of rounds.
        rounds: u32,
        /// Repetitions in it.
        runs: usize,
    },
    /// A repetition ended.
    Timed {
        /// The run's position in the plan.
        index: usize,
        /// Its times, or why there are none.
        lap: Result<Lap, RunError>,
    },
    /// The user interrupted the batch.
    Interrupt,
    /// All threads have finished.
    Drained,
}
