//! Ending runs before their time, and keeping further ones from starting.

use std::sync::atomic::{AtomicBool, Ordering};
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
    pub(super) fn shared(&self) -> Arc<AtomicBool> {
        self.flag.clone()
    }

    /// Why it was cancelled, if it was.
    pub fn reason(&self) -> Option<Reason> {
        self.flag.load(Ordering::Acquire).then(|| self.reason.get().copied()).flatten()
    }
}

/// Stands before the jobs that have not started.
#[derive(Debug, Default)]
pub(super) struct Gate(AtomicBool);

impl Gate {
    /// Lets no further run start.
    pub fn close(&self) {
        self.0.store(true, Ordering::Release);
    }

    pub fn is_closed(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}
