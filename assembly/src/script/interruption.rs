//! Interruption of scripts: a flag and a time limit that every script loaded on this thread polls
//! while it runs.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

thread_local! {
    static CURRENT: RefCell<Interruption> = RefCell::default();
}

/// What ends the scripts of a thread.
#[derive(Clone, Default)]
pub struct Interruption {
    flag: Option<Arc<AtomicBool>>,
    /// Instant at which the limit expires, and the limit.
    deadline: Option<(Instant, Duration)>,
}

impl Interruption {
    /// Why a script has to end now; none if it may continue.
    pub fn reason(&self) -> Option<String> {
        if self.flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)) {
            return Some("interrupted".into());
        }
        let (_, limit) = self.deadline.filter(|(deadline, _)| Instant::now() >= *deadline)?;
        let seconds = limit.as_secs_f64();
        Some(format!("not ready after {seconds} s of wall-clock time; `runner check --timeout` sets this limit"))
    }
}

/// Runs `body`; the scripts that it loads fail once `flag` is set.
pub fn interruptible<R>(flag: Arc<AtomicBool>, body: impl FnOnce() -> R) -> R {
    with(Interruption { flag: Some(flag), ..current() }, body)
}

/// Runs `body`; the scripts that it loads fail once `limit` has passed.
pub fn time_limited<R>(limit: Duration, body: impl FnOnce() -> R) -> R {
    // A limit beyond the clock's range is none.
    let deadline = Instant::now().checked_add(limit).map(|deadline| (deadline, limit));
    with(Interruption { deadline, ..current() }, body)
}

fn with<R>(interruption: Interruption, body: impl FnOnce() -> R) -> R {
    /// Restores the previous interruption however the body ends.
    struct Before(Interruption);
    impl Drop for Before {
        fn drop(&mut self) {
            let before = std::mem::take(&mut self.0);
            CURRENT.with(|current| *current.borrow_mut() = before);
        }
    }
    let _before = Before(CURRENT.with(|current| current.replace(interruption)));
    body()
}

/// The interruption of this thread.
pub(super) fn current() -> Interruption {
    CURRENT.with(|current| current.borrow().clone())
}

/// The flag of this thread, if it has one.
pub fn flag() -> Option<Arc<AtomicBool>> {
    current().flag
}
