//! Mapping a shared library, all its symbols resolved at once: one that is missing is an error here
//! and not the end of the process at its first call.
//!
//! Libraries made of Python (PythonFMU's) expect that the importer is a Python interpreter and define
//! none of its symbols. For them Python's own library is mapped first, with symbols that all see.

use std::error::Error as _;
use std::ffi::OsString;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use libloading::os::unix;

/// Names Python's library for FMUs that need one; any CPython 3 will do for PythonFMU's.
const VARIABLE: &str = "COSIM_LIBPYTHON";
/// Tried in this order without the variable: the one of the stable interface, then versions 3.x.
const STABLE: &str = "libpython3.so";
const VERSIONS: std::ops::RangeInclusive<u32> = 8..=15;

/// Whether Python's library was mapped here.
static PYTHON: AtomicBool = AtomicBool::new(false);

/// Whether an FMU made of Python was loaded, for which Python's library was mapped. The handler that
/// such an FMU (PythonFMU 0.7) has for the end of the process uses memory that it has freed: end the
/// process without such handlers.
pub fn has_mapped_python() -> bool {
    PYTHON.load(Ordering::Relaxed)
}

/// Opens the library at `path`, or says why not.
///
/// # Safety
/// The library's constructors run.
pub(super) unsafe fn library(path: &Path) -> Result<libloading::Library, String> {
    // SAFETY: the caller's promise, here and below.
    match unsafe { unix::Library::open(Some(path), unix::RTLD_NOW | unix::RTLD_LOCAL) } {
        Ok(library) => Ok(library.into()),
        Err(error) => {
            let why = reason(&error);
            if !wants_python(&why) {
                return Err(why);
            }
            provide_python().map_err(|python| format!("{why}; {python}"))?;
            // SAFETY: as above.
            unsafe { unix::Library::open(Some(path), unix::RTLD_NOW | unix::RTLD_LOCAL) }
                .map(Into::into)
                .map_err(|error| reason(&error))
        }
    }
}

/// What the dynamic linker said.
fn reason(error: &libloading::Error) -> String {
    error.source().map_or_else(|| error.to_string(), |source| source.to_string())
}

fn wants_python(why: &str) -> bool {
    why.split_once("undefined symbol: ")
        .is_some_and(|(_, symbol)| symbol.starts_with("Py") || symbol.starts_with("_Py"))
}

/// Maps Python's library for the rest of the process: an interpreter cannot be unloaded.
fn provide_python() -> Result<(), String> {
    let named = std::env::var_os(VARIABLE).map(|name| vec![name]);
    let names = named.unwrap_or_else(|| {
        let versions = VERSIONS.rev().map(|minor| format!("libpython3.{minor}.so.1.0").into());
        std::iter::once(OsString::from(STABLE)).chain(versions).collect()
    });
    for name in &names {
        // SAFETY: Python's library has no constructors that do anything.
        let opened = unsafe { unix::Library::open(Some(name), unix::RTLD_NOW | unix::RTLD_GLOBAL) };
        if let Ok(python) = opened {
            std::mem::forget(python);
            PYTHON.store(true, Ordering::Relaxed);
            return Ok(());
        }
    }
    Err(format!(
        "the FMU is made of Python, and no library of Python was found: install one \
         (libpython3.x.so.1.0) or name it by {VARIABLE}"
    ))
}

#[cfg(test)]
mod tests {
    #[test]
    fn only_symbols_of_python_ask_for_python() {
        let why = |symbol| format!("/tmp/a.so: undefined symbol: {symbol}");
        assert!(super::wants_python(&why("_Py_NoneStruct")));
        assert!(super::wants_python(&why("PyList_New")));
        assert!(!super::wants_python(&why("dgesv_")));
        assert!(!super::wants_python("libPython.so: cannot open shared object file"));
    }
}
