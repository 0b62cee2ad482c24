//! The preparations of an importer before it can call an instance through the C interface.
#![allow(unsafe_code, reason = "calls of the C interface as an importer makes them")]
#![allow(unreachable_pub, reason = "a part of several tests")]

use std::ffi::CString;
use std::ptr::{null, null_mut};

use fmu_kit::abi::types::*;
use rexrov_fmu::{REGISTRY, fmi2};

/// A new instance of a component, which logs nothing.
pub fn instantiate(name: &str, interface: fmi2Type) -> fmi2Component {
    let guid = CString::new(REGISTRY.named(name).unwrap().guid()).unwrap();
    let functions = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    };
    let f = &raw const functions;
    // SAFETY: everything that is pointed to outlives the call; the callbacks may be NULL.
    let c = unsafe {
        fmi2::fmi2Instantiate(c"instance".as_ptr(), interface, guid.as_ptr(), null(), f, 0, 0)
    };
    assert!(!c.is_null());
    c
}
