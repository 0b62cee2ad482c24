//! The memory of an instance: its value, its table of values, its model, all on the heap.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

mod host;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;
use rexrov_fmu::{REGISTRY, fmi2};

/// Maximum size of an instance, in bytes; and of one that keeps its past for late measurements.
const MOST: isize = 8192;
const MOST_WITH_PAST: isize = 500_000;

struct Counting;

thread_local! {
    /// Bytes held by this thread, because the test harness has its own.
    static HELD: Cell<isize> = const { Cell::new(0) };
}

// SAFETY: forwards everything to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        HELD.set(HELD.get() + layout.size() as isize);
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.set(HELD.get() - layout.size() as isize);
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// An instance after initialization.
fn started(name: &str, interface: fmi2Type) -> fmi2Component {
    unsafe {
        let c = host::instantiate(name, interface);
        assert_eq!(fmi2::fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2::fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2::fmi2ExitInitializationMode(c), Status::Ok);
        c
    }
}

#[test]
fn an_initialized_instance_fits_and_leaves_nothing() {
    for entry in REGISTRY.entries() {
        let name = entry.info().name;
        for interface in [0, 1] {
            // The first one allocates the list of handles, which all share.
            unsafe { fmi2::fmi2FreeInstance(started(name, interface)) };
            let before = HELD.get();
            let instance = started(name, interface);
            let bytes = HELD.get() - before;
            unsafe { fmi2::fmi2FreeInstance(instance) };
            // Before anything is printed, because the harness keeps output in memory of this
            // thread.
            let left = HELD.get() - before;
            println!("{name}: {bytes} bytes");
            let most = if name.starts_with("Nav") { MOST_WITH_PAST } else { MOST };
            assert!((1..=most).contains(&bytes), "{name} holds {bytes} bytes");
            assert_eq!(left, 0, "{name} leaves memory behind");
        }
    }
}
