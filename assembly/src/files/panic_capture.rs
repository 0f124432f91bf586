//! Turns a panic of a run, or of a library that reads a damaged file, into an error, without output
//! on the terminal.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static CATCHING: Cell<bool> = const { Cell::new(false) };
    static CAUGHT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Calls `f` and returns a panic as text: its message and location. Panics elsewhere print as usual.
///
/// After a panic, data of `f` is only dropped, so its invariants may be broken.
pub fn catch_panic<T>(f: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let default_hook = take_hook();
        set_hook(Box::new(move |info| if CATCHING.get() { record_panic(info) } else { default_hook(info) }));
    });
    let outer = CATCHING.replace(true);
    let result = catch_unwind(AssertUnwindSafe(f));
    CATCHING.set(outer);
    result.map_err(|_| CAUGHT.take().unwrap_or_else(|| "panicked".into()))
}

fn record_panic(info: &PanicHookInfo) {
    let message = info.payload_as_str().unwrap_or("panicked");
    let location = info.location().map(|at| format!(" at {}:{}", at.file(), at.line())).unwrap_or_default();
    // A second panic during unwinding is a consequence of the first.
    CAUGHT.with_borrow_mut(|caught| caught.get_or_insert_with(|| format!("panic: {message}{location}")).truncate(4000));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_message_and_a_location() {
        let number = "x".parse::<u8>();
        let caught = catch_panic(|| number.clone().expect("a number")).unwrap_err();
        assert!(caught.starts_with("panic: a number: ParseIntError"), "{caught}");
        assert!(caught.contains(" at assembly/src/files/panic_capture.rs:"), "{caught}");
        assert_eq!(catch_panic(|| 3), Ok(3), "the next call is not affected");
    }
}
