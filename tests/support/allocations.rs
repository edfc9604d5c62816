//! Counts what a thread allocates: the proof that nothing between sample and estimate does, and how much a parser takes.
//!
//! The count is the thread's own, so other tests beside it do not disturb it.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, counted.
pub(crate) struct Counted;

thread_local! {
    // Constant initialisation and no destructor: reading it never allocates.
    static COUNT: Cell<u64> = const { Cell::new(0) };
    /// Bytes taken and not given back, and the most of them. Below zero where a thread gives back what another one took.
    static HELD: Cell<i64> = const { Cell::new(0) };
    static MOST: Cell<i64> = const { Cell::new(0) };
}

fn count(taken: usize, given_back: usize) {
    // A thread that is ending has no count any more, and nobody to read it.
    let _ = COUNT.try_with(|count| count.set(count.get() + 1));
    let bytes = |size: usize| i64::try_from(size).unwrap_or(i64::MAX);
    let _ = HELD.try_with(|held| {
        // A block that grows may be there twice while it is copied.
        let most = held.get().saturating_add(bytes(taken));
        held.set(most.saturating_sub(bytes(given_back)));
        let _ = MOST.try_with(|before| before.set(before.get().max(most)));
    });
}

/// How often `run` asked the allocator for something or gave something back.
pub(crate) fn during(run: impl FnOnce()) -> u64 {
    let before = COUNT.with(Cell::get);
    run();
    COUNT.with(Cell::get) - before
}

/// The most bytes that `run` held at one time beyond those that were held before.
#[allow(dead_code, reason = "the tests of the program itself count, they do not measure")]
pub(crate) fn most_bytes_during(run: impl FnOnce()) -> u64 {
    let before = HELD.with(Cell::get);
    MOST.with(|most| most.set(before));
    run();
    u64::try_from(MOST.with(Cell::get) - before).unwrap_or_default()
}

#[expect(unsafe_code, reason = "a global allocator has no safe form; this one only counts and passes on to the system's")]
// SAFETY: every method keeps the contract of `GlobalAlloc` because it hands its arguments unchanged to `System`, which does;
// counting touches thread-local cells, neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: the caller's promises about `layout` are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        count(0, layout.size());
        // SAFETY: `block` came from `System` with this layout, for nothing else allocates here.
        unsafe { System.dealloc(block, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: the caller's promises about `layout` are passed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size, layout.size());
        // SAFETY: `block` came from `System` with this layout; the caller's promise about `size` is passed on.
        unsafe { System.realloc(block, layout, size) }
    }
}
