//! Interface for observers of a batch.

use std::time::Duration;

use crate::batch::{Finished, Job};
use crate::results::claims::ClaimVerdict;
use crate::results::searches::SearchResult;

/// Receives the events of a batch in order, on one thread. Repetitions for timing are not reported.
pub trait Listener {
    /// True if it needs events.
    fn is_active(&self) -> bool {
        true
    }

    /// A run or reference run is already recorded; called before the first run starts.
    fn resumed(&mut self, job: &Job, finished: &Finished) {
        let _ = (job, finished);
    }

    /// A run or a reference run began.
    fn started(&mut self, job: &Job) {
        let _ = job;
    }

    /// The run exceeds [`Options::slow`](crate::batch::Options::slow); called once.
    fn slow(&mut self, job: &Job, after: Duration) {
        let _ = (job, after);
    }

    /// The run ended and its files are written.
    fn finished(&mut self, job: &Job, finished: &Finished) {
        let _ = (job, finished);
    }

    /// The run at a position of the plan was not started, since its claims are decided.
    fn not_needed(&mut self, index: usize) {
        let _ = index;
    }

    /// A search is at its end, or ended with the batch; called when all runs have ended.
    fn searched(&mut self, search: &SearchResult) {
        let _ = search;
    }

    /// A claim is judged; called when all runs have ended.
    fn judged(&mut self, verdict: &ClaimVerdict) {
        let _ = verdict;
    }
}

/// Ignores all events.
pub struct NoListener;

impl Listener for NoListener {
    fn is_active(&self) -> bool {
        false
    }
}

impl Listener for Vec<&mut dyn Listener> {
    fn is_active(&self) -> bool {
        !self.is_empty()
    }

    fn resumed(&mut self, job: &Job, finished: &Finished) {
        self.iter_mut().for_each(|l| l.resumed(job, finished));
    }

    fn started(&mut self, job: &Job) {
        self.iter_mut().for_each(|l| l.started(job));
    }

    fn slow(&mut self, job: &Job, after: Duration) {
        self.iter_mut().for_each(|l| l.slow(job, after));
    }

    fn finished(&mut self, job: &Job, finished: &Finished) {
        self.iter_mut().for_each(|l| l.finished(job, finished));
    }

    fn not_needed(&mut self, index: usize) {
        self.iter_mut().for_each(|l| l.not_needed(index));
    }

    fn searched(&mut self, search: &SearchResult) {
        self.iter_mut().for_each(|l| l.searched(search));
    }

    fn judged(&mut self, verdict: &ClaimVerdict) {
        self.iter_mut().for_each(|l| l.judged(verdict));
    }
}
