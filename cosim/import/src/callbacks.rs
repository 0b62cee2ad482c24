//! The functions that an FMU calls back: logger and memory.
//!
//! FMI's logger is variadic like `printf`. [`variadic`] finds the arguments, and [`printf`] renders
//! them without trusting the FMU.

use std::ffi::{c_char, c_void};

use super::log::Log;
use super::status::RawStatus;
pub(super) use live::Known;
use variadic::Arguments;

mod live;
mod memory;
mod printf;
mod variadic;

/// Shown instead of a string at an address that cannot be read.
const UNREADABLE: &[u8] = b"(not a readable string)";

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub(super) struct Callbacks {
    pub logger: variadic::Logger,
    pub allocate_memory: extern "C" fn(usize, usize) -> *mut c_void,
    pub free_memory: unsafe extern "C" fn(*mut c_void),
    /// Does nothing: steps in the background are polled with `fmi2GetStatus`. Not NULL, because
    /// some FMUs call it without a check.
    pub step_finished: extern "C" fn(*const Log, RawStatus),
    pub environment: *const Log,
}

impl Callbacks {
    pub(super) fn new(log: &Log) -> Self {
        Self {
            logger: variadic::logger,
            allocate_memory: allocate,
            free_memory: free,
            step_finished,
            environment: log,
        }
    }
}

extern "C" fn step_finished(_: *const Log, _: RawStatus) {}

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

/// Logs a message with the arguments that the variadic logger has found. No pointer needs to be
/// valid.
fn logged(
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
    // One more, so that a longer message is marked as cut.
    let [category, format] = [category, format].map(|text| bytes(text, printf::MAX_MESSAGE + 1));
    let message = match arguments {
        Some(arguments) => printf::render(&format, arguments),
        None => String::from_utf8_lossy(&format).into_owned(),
    };
    log.message(status, &String::from_utf8_lossy(&category), message.trim_end());
}

/// A copy of a C string from an FMU: empty for NULL; an invalid pointer is not dereferenced.
pub(super) fn text(pointer: *const c_char) -> String {
    String::from_utf8_lossy(&bytes(pointer, usize::MAX)).into_owned()
}

fn bytes(pointer: *const c_char, limit: usize) -> Vec<u8> {
    match pointer.is_null() {
        true => Vec::new(),
        false => memory::string(pointer.addr(), limit).unwrap_or_else(|| UNREADABLE.to_vec()),
    }
}
