//! Cancels active runs and prevents further ones from starting.

use std::num::NonZero;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// Why a run was cancelled.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reason {
    /// The batch was interrupted.
    Interrupted,
    /// It exceeded its wall-clock limit.
    TimedOut,
}

/// Flag that ends one run at its next step, with the reason.
#[derive(Debug, Default)]
pub struct Cancellation {
    flag: Arc<AtomicBool>,
    reason: OnceLock<Reason>,
}

impl Cancellation {
    /// Cancels the run; keeps the first reason.
    pub fn cancel(&self, reason: Reason) {
        let _ = self.reason.set(reason);
        self.flag.store(true, Ordering::Release);
    }

    /// The flag that the simulation polls.
    pub fn flag(&self) -> &AtomicBool {
        &self.flag
    }

    /// The flag as a shared handle, for scripts.
    pub(in crate::batch) fn shared(&self) -> Arc<AtomicBool> {
        self.flag.clone()
    }

    /// The reason of the cancellation; none if the run was not cancelled.
    pub fn reason(&self) -> Option<Reason> {
        self.flag.load(Ordering::Acquire).then(|| self.reason.get().copied()).flatten()
    }
}

/// Lets jobs start until it is closed.
#[derive(Debug, Default)]
pub(in crate::batch) struct Gate {
    closed: AtomicBool,
    failures: AtomicUsize,
}

impl Gate {
    /// Prevents further runs from starting.
    pub fn close(&self) {
        self.closed.store(true, Ordering::Release);
    }

    /// Counts a run that was not accepted; closes the gate at the `limit`-th.
    pub fn count_failure(&self, limit: Option<NonZero<usize>>) {
        let failures = self.failures.fetch_add(1, Ordering::AcqRel) + 1;
        if limit.is_some_and(|limit| failures >= limit.get()) {
            self.close();
        }
    }

    pub fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }
}
