//! The functions that an FMU calls back: logger and memory.
//!
//! FMI's logger is variadic like `printf`. [`variadic`] finds the arguments, and [`printf`] renders
//! them without trusting the FMU.

use std::ffi::{CStr, c_char, c_void};

use super::log::Log;
use super::status::RawStatus;
pub(super) use live::Known;
use variadic::Arguments;

mod live;
mod memory;
mod printf;
mod variadic;

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub(super) struct Callbacks {
    pub logger: variadic::Logger,
    pub allocate_memory: extern "C" fn(usize, usize) -> *mut c_void,
    pub free_memory: unsafe extern "C" fn(*mut c_void),
    /// NULL: steps in the background are polled with `fmi2GetStatus`.
    pub step_finished: *const c_void,
    pub environment: *const Log,
}

impl Callbacks {
    pub(super) fn new(log: &Log) -> Self {
        Self {
            logger: variadic::logger,
            allocate_memory: allocate,
            free_memory: free,
            step_finished: std::ptr::null(),
            environment: log,
        }
    }
}

/// Zeroed memory as FMI requires; `calloc` also detects an overflow of the product. It is also
/// provided to FMUs with canNotUseMemoryManagementFunctions, because some use it anyway.
extern "C" fn allocate(count: usize, size: usize) -> *mut c_void {
    // SAFETY: calloc accepts any two numbers.
    unsafe { libc::calloc(count, size) }
}

/// # Safety
/// `pointer` is NULL or from [`allocate`].
unsafe extern "C" fn free(pointer: *mut c_void) {
    // SAFETY: the caller passes NULL or memory of calloc.
    unsafe { libc::free(pointer) }
}

/// Logs a message with the arguments that the variadic logger has found.
///
/// # Safety
/// Category and format are NULL or C strings; the other pointers need not be valid.
unsafe fn logged(
    environment: *const Log,
    instance: *const c_char,
    status: RawStatus,
    category: *const c_char,
    format: *const c_char,
    arguments: Option<&mut Arguments>,
) {
    let Some(log) = live::find(environment.addr(), instance) else {
        return;
    };
    // SAFETY: the FMU passes NULL or C strings that live during this call.
    let (category, format) = unsafe { (text(category), bytes(format)) };
    let message = match arguments {
        Some(arguments) => printf::render(format, arguments),
        None => String::from_utf8_lossy(format).into_owned(),
    };
    log.message(status, &category, message.trim_end());
}

/// A copy of a C string; empty for NULL.
///
/// # Safety
/// `pointer` is NULL or a C string.
pub(super) unsafe fn text(pointer: *const c_char) -> String {
    // SAFETY: as for this function.
    String::from_utf8_lossy(unsafe { bytes(pointer) }).into_owned()
}

/// # Safety
/// `pointer` is NULL or a C string that outlives the returned reference.
unsafe fn bytes<'a>(pointer: *const c_char) -> &'a [u8] {
    if pointer.is_null() {
        return &[];
    }
    // SAFETY: not NULL, so a C string by the function's contract.
    unsafe { CStr::from_ptr(pointer) }.to_bytes()
}
