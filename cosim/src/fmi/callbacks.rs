//! The functions an FMU calls back: logger and memory.
//!
//! FMI's logger is variadic like `printf`, and stable Rust cannot define such a function. The
//! ABIs of Linux on x86-64 (System V) and AArch64 (AAPCS64) pass the leading integer and pointer
//! arguments of a variadic call in the registers of a plain one, so [`logger`] has one more fixed
//! argument that holds the first variadic one *if there is one*. It is looked at only when the
//! format has exactly one conversion, which promises that it was passed (`"%s", text` is the
//! common form). Any other format is shown as it stands, with a note.

use std::ffi::{CStr, c_char, c_void};

use super::log::Log;
use super::status::{self, RawStatus};

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub(super) struct Callbacks {
    pub logger: Logger,
    pub allocate_memory: extern "C" fn(usize, usize) -> *mut c_void,
    pub free_memory: unsafe extern "C" fn(*mut c_void),
    /// NULL: a step is finished when `fmi2DoStep` returns.
    pub step_finished: *const c_void,
    pub environment: *const Log,
}

type Logger =
    unsafe extern "C" fn(*const Log, *const c_char, RawStatus, *const c_char, *const c_char, usize);

impl Callbacks {
    pub(super) fn new(log: &Log) -> Self {
        Self {
            logger,
            allocate_memory: allocate,
            free_memory: free,
            step_finished: std::ptr::null(),
            environment: log,
        }
    }
}

/// Zeroed memory as FMI asks; `calloc` also catches the product that overflows.
extern "C" fn allocate(count: usize, size: usize) -> *mut c_void {
    // SAFETY: calloc takes any two numbers.
    unsafe { libc::calloc(count, size) }
}

/// # Safety
/// `pointer` is NULL or from [`allocate`].
unsafe extern "C" fn free(pointer: *mut c_void) {
    // SAFETY: the caller passes NULL or memory of calloc.
    unsafe { libc::free(pointer) }
}

/// # Safety
/// `log` is NULL or the `environment` of a living instance; the strings are NULL or C strings;
/// `first` is the argument of the format's conversion if it has one.
unsafe extern "C" fn logger(
    log: *const Log,
    _instance: *const c_char,
    status: RawStatus,
    category: *const c_char,
    format: *const c_char,
    first: usize,
) {
    // SAFETY: the instance keeps its Log alive until after fmi2FreeInstance.
    let Some(log) = (unsafe { log.as_ref() }) else {
        return;
    };
    // SAFETY: the FMU passes NULL or C strings that live during this call.
    let (category, format) = unsafe { (text(category), text(format)) };
    // SAFETY: `first` belongs to the conversion in `format`, if there is exactly one.
    let message = unsafe { render(&format, first) };
    log.push(format!("{} ({category}): {}", status::name(status), message.trim_end()));
}

/// A copy of a C string; empty for NULL.
///
/// # Safety
/// `pointer` is NULL or a C string.
pub(super) unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: not NULL, so a C string by the function's contract.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}

/// # Safety
/// If `format` has exactly one conversion, `first` is its argument.
unsafe fn render(format: &str, first: usize) -> String {
    match single_conversion(format) {
        Conversions::None => format.replace("%%", "%"),
        Conversions::One { before, kind, after } => {
            let value = match kind {
                // SAFETY: the argument of %s is NULL or a C string.
                's' => unsafe { text(first as *const c_char) },
                // The upper half of the register of a C int is undefined.
                'd' | 'i' => (first as u32 as i32).to_string(),
                _ => (first as u32).to_string(),
            };
            format!("{}{value}{}", before.replace("%%", "%"), after.replace("%%", "%"))
        }
        Conversions::Other => format!("{format} (the values are not shown)"),
    }
}

#[derive(Debug, PartialEq)]
enum Conversions<'a> {
    None,
    One { before: &'a str, kind: char, after: &'a str },
    Other,
}

/// Finds the conversion of a format that has just one, of the plain kinds s, d, i and u.
fn single_conversion(format: &str) -> Conversions<'_> {
    let mut found = Conversions::None;
    let mut rest = 0;
    while let Some(offset) = format[rest..].find('%') {
        let at = rest + offset;
        match format[at + 1..].chars().next() {
            Some('%') => (),
            Some(kind @ ('s' | 'd' | 'i' | 'u')) if found == Conversions::None => {
                found = Conversions::One { before: &format[..at], kind, after: &format[at + 2..] };
            }
            _ => return Conversions::Other,
        }
        rest = at + 2;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(format: &str, first: usize) -> String {
        // SAFETY: the tests pass what their format promises.
        unsafe { render(format, first) }
    }

    #[test]
    fn one_conversion_is_rendered() {
        let name = c"tank";
        assert_eq!(shown("%s", name.as_ptr() as usize), "tank");
        assert_eq!(shown("100%% of %s empty", name.as_ptr() as usize), "100% of tank empty");
        assert_eq!(shown("step %d", 0xdead_beef_ffff_ffff), "step -1");
    }

    #[test]
    fn nothing_is_read_that_was_not_promised() {
        // The address 1 would crash when read.
        for format in ["plain", "100%%", "%s and %s", "%f", "%5s", "%", "x %"] {
            shown(format, 1);
        }
        assert!(shown("%s is %f", 1).contains("not shown"));
    }
}
