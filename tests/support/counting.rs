//! Counts allocations per thread, so that concurrent tests do not affect the counts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
    static HELD: Cell<isize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is forwarded to the system allocator unchanged; the counter is a plain
// thread-local integer that never allocates.
#[allow(unsafe_code)] // An allocator cannot be written without.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        HELD.set(HELD.get() + layout.size() as isize);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.set(HELD.get() - layout.size() as isize);
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        HELD.set(HELD.get() + size as isize - layout.size() as isize);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Number of allocations and reallocations that `f` makes on this thread.
pub fn count(f: impl FnOnce()) -> usize {
    let before = COUNT.get();
    f();
    COUNT.get() - before
}

/// Net change of the bytes allocated by this thread while `f` runs.
pub fn balance(f: impl FnOnce()) -> isize {
    let before = HELD.get();
    f();
    HELD.get() - before
}

#[test]
fn the_counter_counts_allocations() {
    let mut list: Vec<u8> = Vec::new();
    assert_eq!(count(|| list = std::hint::black_box(Vec::with_capacity(10))), 1);
    assert_eq!(count(|| list.reserve(1000)), 1);
    assert_eq!(count(|| list.clear()), 0);
    assert_eq!(balance(|| drop(std::mem::take(&mut list))), -1000);
}
