//! Limits the memory of readers to a multiple of their input. Counted by an allocator, separately
//! for each thread.
#![allow(unsafe_code, reason = "counts what is allocated")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Bytes of memory allowed for each byte of input, and a fixed amount for the reader itself, as
/// SECURITY.md says.
const MULTIPLE: i64 = 512;
const ANYWAY: i64 = 64 << 20;

/// Counts the memory of this thread, and its maximum.
struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

thread_local! {
    static COUNTED: Cell<(i64, i64)> = const { Cell::new((0, 0)) };
}

fn count(bytes: i64) {
    // For a thread that is ending, nothing needs the counters any more.
    let _ = COUNTED.try_with(|counted| {
        let (has, most) = counted.get();
        counted.set((has + bytes, most.max(has + bytes)));
    });
}

// SAFETY: everything is delegated to the system allocator; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: the caller's promise, here and below.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        count(-(layout.size() as i64));
        // SAFETY: as above.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // During the copy, both exist.
        count(size as i64);
        count(-(layout.size() as i64));
        // SAFETY: as above.
        unsafe { System.realloc(place, layout, size) }
    }
}

/// Runs a reader and checks that it stays within its memory budget.
pub fn within(reader: fn(&[u8]), bytes: &[u8]) {
    let before = COUNTED.with(|counted| {
        let (has, _) = counted.get();
        counted.set((has, has));
        has
    });
    reader(bytes);
    let most = COUNTED.with(Cell::get).1 - before;
    let allowed = ANYWAY + MULTIPLE * bytes.len() as i64;
    assert!(
        most <= allowed,
        "{most} bytes of memory for {} bytes, {allowed} are allowed",
        bytes.len()
    );
}
