//! Once initialized, setting, stepping and getting never allocate.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]
#![allow(unreachable_pub, reason = "shared with the other tests")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

#[path = "fmi2/components.rs"]
mod components;
#[expect(dead_code, reason = "shared with the other tests")]
#[path = "fmi2/driver.rs"]
mod driver;

use driver::{CS, Fmu};
use fmu_kit::kernel::Status;

struct Counting;

thread_local! {
    /// Of this thread, since the test harness has its own.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: passes everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn set_step_and_get_do_not_allocate() {
    for (name, input, output) in [("Spring", "force", "acceleration"), ("Noise", "signal", "value")]
    {
        let mut fmu = Fmu::started(name, CS);
        let (input, output) = (fmu.reference(input), fmu.reference(output));
        let before = ALLOCATIONS.get();
        let mut value = 0.0;
        for k in 0..1000 {
            let force = f64::from(k);
            unsafe {
                let c = fmu.c;
                let set = components::fmi2::fmi2SetReal(c, &raw const input, 1, &raw const force);
                let step = fmu.step(f64::from(k) * 0.01, 0.01);
                let get = components::fmi2::fmi2GetReal(c, &raw const output, 1, &raw mut value);
                assert_eq!([set, step, get], [Status::Ok; 3]);
            }
        }
        assert_eq!(ALLOCATIONS.get(), before, "{name}");
    }
}
