//! An importer with little memory left: errors instead of a crash.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;
use rexrov_fmu::{REGISTRY, fmi2};

/// Memory reserved for error messages, and the largest amount that no message needs at once
/// (bytes).
const TEXTS: isize = 64 << 10;
const LARGE: usize = 4 << 10;

struct Scarce;

thread_local! {
    /// Bytes that this thread may still allocate.
    static LEFT: Cell<isize> = const { Cell::new(isize::MAX / 2) };
}

// SAFETY: forwards to the system's allocator what it does not reject.
unsafe impl GlobalAlloc for Scarce {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let rest = LEFT.get() - layout.size() as isize;
        let least = if layout.size() < LARGE { -TEXTS } else { 0 };
        if rest < least {
            return null_mut();
        }
        LEFT.set(rest);
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LEFT.set(LEFT.get() + layout.size() as isize);
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Scarce = Scarce;

/// How often a call succeeds, for calls with more and more bytes left, from none to plenty. It must
/// be neither always nor never.
fn tried(name: &str, mut call: impl FnMut() -> bool) {
    let succeeds = |power: &u32| {
        let before = LEFT.replace((1 << power) - 1);
        let success = call();
        LEFT.set(before);
        success
    };
    let successes = (0..26).filter(succeeds).count();
    assert!((1..26).contains(&successes), "{name}: {successes}");
}

fn instantiate(guid: &CStr) -> fmi2Component {
    let functions = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    };
    let f = &raw const functions;
    unsafe { fmi2::fmi2Instantiate(c"x".as_ptr(), 1, guid.as_ptr(), null(), f, 0, 0) }
}

fn started(guid: &CStr) -> fmi2Component {
    let c = instantiate(guid);
    unsafe {
        assert_eq!(fmi2::fmi2EnterInitializationMode(c), Status::Ok);
        assert_eq!(fmi2::fmi2ExitInitializationMode(c), Status::Ok);
    }
    c
}

#[test]
fn instances_and_states_are_refused_where_memory_is_short() {
    for entry in REGISTRY.entries() {
        let name = entry.info().name;
        let guid = CString::new(entry.guid()).unwrap();
        tried(name, || {
            let c = instantiate(&guid);
            unsafe { fmi2::fmi2FreeInstance(c) };
            !c.is_null()
        });
        let (c, mut state, mut size) = (started(&guid), null_mut(), 0);
        unsafe {
            assert_eq!(fmi2::fmi2GetFMUstate(c, &raw mut state), Status::Ok);
            assert_eq!(fmi2::fmi2SerializedFMUstateSize(c, state, &raw mut size), Status::Ok);
        }
        let mut image: Vec<fmi2Byte> = vec![0; size];
        let at = image.as_mut_ptr();
        tried(name, || unsafe { fmi2::fmi2SerializeFMUstate(c, state, at, size) == Status::Ok });
        tried(name, || unsafe {
            let mut again = null_mut();
            let status = fmi2::fmi2GetFMUstate(c, &raw mut again);
            fmi2::fmi2FreeFMUstate(c, &raw mut again);
            status == Status::Ok
        });
        tried(name, || unsafe {
            let mut read = null_mut();
            let status = fmi2::fmi2DeSerializeFMUstate(c, at, size, &raw mut read);
            fmi2::fmi2FreeFMUstate(c, &raw mut read);
            status == Status::Ok
        });
        let others: Vec<fmi2Component> = (0..26).map(|_| started(&guid)).collect();
        let mut next = others.iter();
        // Their parameters belong to other editions: their components are built again.
        tried(name, || unsafe {
            fmi2::fmi2SetFMUstate(*next.next().unwrap(), state) == Status::Ok
        });
        for instance in others.into_iter().chain([c]) {
            unsafe { fmi2::fmi2FreeInstance(instance) };
        }
    }
}
