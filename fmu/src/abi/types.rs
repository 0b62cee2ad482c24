//! `fmi2TypesPlatform.h` and the types of `fmi2FunctionTypes.h`.
#![expect(non_camel_case_types, reason = "named as in the standard's headers")]

use std::ffi::{c_char, c_int, c_uint, c_void};

use crate::kernel::Status;

/// An instance, opaque to the importer.
pub type fmi2Component = *mut c_void;
/// The importer's own data, handed back to its logger.
pub type fmi2ComponentEnvironment = *mut c_void;
/// A saved state, opaque to the importer.
pub type fmi2FMUstate = *mut c_void;
/// Handle of a variable.
pub type fmi2ValueReference = c_uint;
/// A Real.
pub type fmi2Real = f64;
/// An Integer or Enumeration.
pub type fmi2Integer = c_int;
/// A Boolean: 0 is false.
pub type fmi2Boolean = c_int;
/// A character.
pub type fmi2Char = c_char;
/// A NUL-terminated string in UTF-8.
pub type fmi2String = *const fmi2Char;
/// A byte.
pub type fmi2Byte = c_char;
/// The status a function returns.
pub type fmi2Status = Status;
/// `fmi2ModelExchange` = 0, `fmi2CoSimulation` = 1; a plain number since C may pass any.
pub type fmi2Type = c_int;
/// `fmi2DoStepStatus` = 0 … `fmi2Terminated` = 3; a plain number since C may pass any.
pub type fmi2StatusKind = c_int;

/// `fmi2True`
pub const FMI2_TRUE: fmi2Boolean = 1;
/// `fmi2False`
pub const FMI2_FALSE: fmi2Boolean = 0;

/// The importer's logger; printf-like.
pub type fmi2CallbackLogger = unsafe extern "C" fn(
    environment: fmi2ComponentEnvironment,
    instance_name: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
    ...
);

/// What the importer provides; only the logger is used.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fmi2CallbackFunctions {
    /// Takes messages; may be missing.
    pub logger: Option<fmi2CallbackLogger>,
    /// Not used: memory is Rust's own, as `canNotUseMemoryManagementFunctions` declares.
    pub allocateMemory: Option<unsafe extern "C" fn(nobj: usize, size: usize) -> *mut c_void>,
    /// Not used.
    pub freeMemory: Option<unsafe extern "C" fn(obj: *mut c_void)>,
    /// Not used: steps are synchronous.
    pub stepFinished:
        Option<unsafe extern "C" fn(environment: fmi2ComponentEnvironment, status: fmi2Status)>,
    /// Handed back to the logger.
    pub componentEnvironment: fmi2ComponentEnvironment,
}

/// What `fmi2NewDiscreteStates` reports.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "named as in the standard")]
pub struct fmi2EventInfo {
    pub newDiscreteStatesNeeded: fmi2Boolean,
    pub terminateSimulation: fmi2Boolean,
    pub nominalsOfContinuousStatesChanged: fmi2Boolean,
    pub valuesOfContinuousStatesChanged: fmi2Boolean,
    pub nextEventTimeDefined: fmi2Boolean,
    pub nextEventTime: fmi2Real,
}
