//! Loaded, run and unloaded repeatedly, as tools do for every simulation: nothing is left.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![cfg(all(target_os = "linux", target_env = "gnu"))]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each is a call of the C interface as an importer makes it"
)]

use std::ffi::CString;
use std::ptr::{null, null_mut};

use fmu_kit::abi::types::*;
use fmu_kit::kernel::Status;
use libloading::Library;
use rexrov_fmu::REGISTRY;

/// Repetitions, and how many bytes each may leave: none, but the count includes the test's own
/// memory and some ten thousand bytes in total that are free but cached by the allocator.
const LIVES: usize = 1000;
const LEFT: usize = 64;

/// `struct mallinfo2` of glibc: ten numbers, of which the eighth is the allocated memory.
#[repr(C)]
struct Allocated {
    before: [usize; 7],
    bytes: usize,
    after: [usize; 2],
}

unsafe extern "C" {
    fn mallinfo2() -> Allocated;
}

type Instantiate = unsafe extern "C" fn(
    fmi2String,
    fmi2Type,
    fmi2String,
    fmi2String,
    *const fmi2CallbackFunctions,
    fmi2Boolean,
    fmi2Boolean,
) -> fmi2Component;
type Plain = unsafe extern "C" fn(fmi2Component) -> fmi2Status;
type Step = unsafe extern "C" fn(fmi2Component, f64, f64, fmi2Boolean) -> fmi2Status;
type Free = unsafe extern "C" fn(fmi2Component);

/// Loads the library, runs a component, and unloads the library.
fn life(name: &str) {
    let library = std::env::current_exe().unwrap().with_file_name("librexrov_fmu.so");
    let guid = CString::new(REGISTRY.named(name).unwrap().guid()).unwrap();
    let functions = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    };
    let f = &raw const functions;
    unsafe {
        let library = Library::new(library).unwrap();
        let instantiate = library.get::<Instantiate>(b"fmi2Instantiate").unwrap();
        let plain = |name: &str| library.get::<Plain>(name.as_bytes()).unwrap();
        let c = instantiate(c"x".as_ptr(), 1, guid.as_ptr(), null(), f, 0, 0);
        assert!(!c.is_null(), "{name}: library and test are of different builds");
        assert_eq!(plain("fmi2EnterInitializationMode")(c), Status::Ok);
        assert_eq!(plain("fmi2ExitInitializationMode")(c), Status::Ok);
        let step = library.get::<Step>(b"fmi2DoStep").unwrap();
        assert_eq!(step(c, 0.0, 1.0, 1), Status::Ok);
        library.get::<Free>(b"fmi2FreeInstance").unwrap()(c);
        library.close().unwrap();
    }
}

#[test]
fn lives_of_a_library_leave_nothing() {
    let allocated = || unsafe { mallinfo2() }.bytes;
    for name in ["Gps", "NavModelAided"] {
        (0..100).for_each(|_| life(name));
        let before = allocated();
        (0..LIVES).for_each(|_| life(name));
        let left = allocated().saturating_sub(before);
        let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
        assert!(!maps.contains("librexrov_fmu.so"), "the library is still mapped");
        assert!(left <= LEFT * LIVES, "{name}: {left} bytes are left of {LIVES} lives");
    }
}
