//! Ending runs before their time, and keeping further ones from starting.

use std::num::NonZero;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// Why a run is ended from outside.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reason {
    /// A person does not want it any more.
    Interrupted,
    /// It used up its wall-clock time.
    TimedOut,
}

/// The flag that ends one run at its next step, and why it was raised.
#[derive(Debug, Default)]
pub struct Cancellation {
    flag: Arc<AtomicBool>,
    reason: OnceLock<Reason>,
}

impl Cancellation {
    /// Ends the run; the first reason stays.
    pub fn cancel(&self, reason: Reason) {
        let _ = self.reason.set(reason);
        self.flag.store(true, Ordering::Release);
    }

    /// The flag that the simulation looks at.
    pub fn flag(&self) -> &AtomicBool {
        &self.flag
    }

    /// The same, for scripts.
    pub(in crate::batch) fn shared(&self) -> Arc<AtomicBool> {
        self.flag.clone()
    }

    /// Why it was cancelled, if it was.
    pub fn reason(&self) -> Option<Reason> {
        self.flag.load(Ordering::Acquire).then(|| self.reason.get().copied()).flatten()
    }
}

/// Stands before the jobs that have not started.
#[derive(Debug, Default)]
pub(in crate::batch) struct Gate {
    closed: AtomicBool,
    failures: AtomicUsize,
}

impl Gate {
    /// Lets no further run start.
    pub fn close(&self) {
        self.closed.store(true, Ordering::Release);
    }

    /// Counts a run that did not end as it should; the last one that is allowed closes the gate.
    pub fn count_failure(&self, most: Option<NonZero<usize>>) {
        let failures = self.failures.fetch_add(1, Ordering::AcqRel) + 1;
        if most.is_some_and(|most| failures >= most.get()) {
            self.close();
        }
    }

    pub fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }
}
