//! Turns a panic in a run into that run's outcome, without output on the terminal.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static CATCHING: Cell<bool> = const { Cell::new(false) };
    static CAUGHT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Calls `f` and returns a panic as its message and location. Panics elsewhere print as usual.
///
/// After a panic, data of `f` is only dropped, so its invariants may be broken.
pub(in crate::batch) fn catch_panic<T>(f: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let shown = take_hook();
        set_hook(Box::new(move |info| if CATCHING.get() { keep(info) } else { shown(info) }));
    });
    let outer = CATCHING.replace(true);
    let result = catch_unwind(AssertUnwindSafe(f));
    CATCHING.set(outer);
    result.map_err(|_| CAUGHT.take().unwrap_or_else(|| "panicked".into()))
}

fn keep(info: &PanicHookInfo) {
    let words = info.payload_as_str().unwrap_or("panicked");
    let place = info.location().map(|at| format!(" at {}:{}", at.file(), at.line())).unwrap_or_default();
    // A second panic during unwinding is a consequence of the first.
    CAUGHT.with_borrow_mut(|caught| caught.get_or_insert_with(|| format!("panic: {words}{place}")).truncate(4000));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_words_and_a_place() {
        let number = "x".parse::<u8>();
        let caught = catch_panic(|| number.clone().expect("a number")).unwrap_err();
        assert!(caught.starts_with("panic: a number: ParseIntError"), "{caught}");
        assert!(caught.contains(" at src/batch/run/panic_capture.rs:"), "{caught}");
        assert_eq!(catch_panic(|| 3), Ok(3), "the next one is unharmed");
    }
}
