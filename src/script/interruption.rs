//! Interruption of scripts: a flag that every script loaded on this thread polls while it runs.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

thread_local! {
    static FLAG: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// Runs `body`; the scripts that it loads fail once `flag` is set.
pub fn interruptible<R>(flag: Arc<AtomicBool>, body: impl FnOnce() -> R) -> R {
    /// Restores the previous flag however the body ends.
    struct Before(Option<Arc<AtomicBool>>);
    impl Drop for Before {
        fn drop(&mut self) {
            let before = self.0.take();
            FLAG.with(|f| *f.borrow_mut() = before);
        }
    }
    let _before = Before(FLAG.with(|f| f.borrow_mut().replace(flag)));
    body()
}

/// The flag of this thread, if it has one.
pub(crate) fn flag() -> Option<Arc<AtomicBool>> {
    FLAG.with(|f| f.borrow().clone())
}
