//! An allocator that counts its uses on a thread that may not use it.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// How often this thread has used the allocator though it may not.
    pub static USES: Cell<u64> = const { Cell::new(0) };
    /// Whether this thread may not use the allocator.
    pub static FORBIDDEN: Cell<bool> = const { Cell::new(false) };
}

/// The system's allocator, which counts its uses while they are forbidden.
struct Watched;

fn note() {
    if FORBIDDEN.get() {
        USES.set(USES.get() + 1);
    }
}

// SAFETY: every call goes to the system's allocator unchanged
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        note();
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note();
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Watched = Watched;
