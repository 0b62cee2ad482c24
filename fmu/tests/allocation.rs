//! Once initialized, setting, stepping and getting never allocate.
#![allow(unsafe_code, reason = "counts what is allocated")]
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
#[path = "fmi2/hybrid.rs"]
mod hybrid;

use driver::{CS, Fmu};
use fmu_kit::kernel::Status;

struct Counting;

thread_local! {
    /// For this thread, because the test harness has its own.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: forwards everything to the system's allocator.
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

#[test]
fn the_adaptive_integrator_and_restoring_a_state_do_not_allocate() {
    for (name, method) in [("Spring", 2), ("Noise", 0), ("Ball", 1), ("Pendulum", 2)] {
        let mut fmu = Fmu::new(name, CS);
        if method > 0 {
            fmu.set_integer("integrator.method", method);
        }
        fmu.setup(0.0);
        fmu.initialize();
        let mut state = std::ptr::null_mut();
        let c = fmu.c;
        unsafe { components::fmi2::fmi2GetFMUstate(c, &raw mut state) };
        let before = ALLOCATIONS.get();
        for k in 0..100 {
            let t = f64::from(k) * 0.1;
            unsafe {
                let get = components::fmi2::fmi2GetFMUstate(c, &raw mut state);
                let step = fmu.step(t, 0.1);
                let set = components::fmi2::fmi2SetFMUstate(c, state);
                assert_eq!([get, step, set, fmu.step(t, 0.1)], [Status::Ok; 4]);
            }
        }
        assert_eq!(ALLOCATIONS.get(), before, "{name}");
    }
}
