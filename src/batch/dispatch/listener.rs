//! Being told what happens in a batch.

use std::time::Duration;

use crate::batch::{Finished, Job};

/// One who is told what happens in a batch, in the order in which it happened, all on one thread. Repetitions for timing
/// are not told of.
pub trait Listener {
    /// Is there anybody?
    fn is_active(&self) -> bool {
        true
    }

    /// A run or a reference run need not be made: its records were there. Told of all these before the first begins.
    fn kept(&mut self, job: &Job, finished: &Finished) {
        let _ = (job, finished);
    }

    /// A run or a reference run began.
    fn started(&mut self, job: &Job) {
        let _ = job;
    }

    /// It has been going for longer than [`Options::slow`](crate::batch::Options::slow); told once.
    fn slow(&mut self, job: &Job, after: Duration) {
        let _ = (job, after);
    }

    /// It ended and its files are written.
    fn finished(&mut self, job: &Job, finished: &Finished) {
        let _ = (job, finished);
    }
}

/// One who does not listen.
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

    fn kept(&mut self, job: &Job, finished: &Finished) {
        self.iter_mut().for_each(|l| l.kept(job, finished));
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
}
