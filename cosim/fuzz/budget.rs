//! What readers may take: memory at most a multiple of what they read. Counted by an allocator, thread
//! by thread.
#![allow(unsafe_code, reason = "counts what is allocated")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Bytes of memory for each byte that is read, and for what a reader needs anyway.
const MULTIPLE: i64 = 512;
const ANYWAY: i64 = 16 << 20;

/// Counts what this thread has, and the most that it had.
struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

thread_local! {
    static COUNTED: Cell<(i64, i64)> = const { Cell::new((0, 0)) };
}

fn count(bytes: i64) {
    // A thread that ends has nobody who asks.
    let _ = COUNTED.try_with(|counted| {
        let (has, most) = counted.get();
        counted.set((has + bytes, most.max(has + bytes)));
    });
}

// SAFETY: all is done by the system's allocator; counting allocates nothing.
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
        // While it is copied, both are there.
        count(size as i64);
        count(-(layout.size() as i64));
        // SAFETY: as above.
        unsafe { System.realloc(place, layout, size) }
    }
}

/// Feeds a reader and sees that it keeps to its memory.
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
