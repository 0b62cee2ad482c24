//! Maps a shared library and resolves all its symbols at once: a missing symbol is an error here
//! instead of the end of the process at its first call.
//!
//! Libraries of PythonFMU expect that the importer is a Python interpreter and do not link its
//! symbols. For them, Python's own library is mapped first, with global symbols. Libraries that an
//! FMU contains beside its own are found there, even if its own library has no search path.

use std::error::Error as _;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use libloading::Library;
use libloading::os::unix;

/// Names Python's library for FMUs that need one; any CPython 3 works for PythonFMU.
const VARIABLE: &str = "COSIM_LIBPYTHON";
/// Tried in this order without the variable: the library of the stable interface, then versions
/// 3.x.
const STABLE: &str = "libpython3.so";
const VERSIONS: std::ops::RangeInclusive<u32> = 8..=15;

/// Whether Python's library was mapped here.
static PYTHON: AtomicBool = AtomicBool::new(false);

fn has_mapped_python() -> bool {
    PYTHON.load(Ordering::Relaxed)
}

/// A library, and the libraries beside it that it needs; they are unmapped in this order.
pub(super) struct Opened {
    pub(super) library: Library,
    _beside: Vec<Library>,
}

/// Opens the library at `path`; the error says why that fails.
///
/// # Safety
/// The library's constructors run.
pub(super) unsafe fn library(path: &Path) -> Result<Opened, String> {
    let (mut beside, mut opened) = (Vec::new(), Vec::new());
    loop {
        // SAFETY: the caller's promise, here and below.
        let why = match unsafe { open(path) } {
            Ok(library) => return Ok(Opened { library, _beside: beside }),
            Err(why) => why,
        };
        match missing_beside(&why, path).filter(|file| !opened.contains(file)) {
            Some(file) => {
                // SAFETY: as above.
                beside.push(unsafe { open(&file) }.map_err(|of_it| format!("{why}; {of_it}"))?);
                opened.push(file);
            }
            None if wants_python(&why) && !has_mapped_python() => {
                provide_python().map_err(|python| format!("{why}; {python}"))?;
            }
            None => return Err(why),
        }
    }
}

/// # Safety
/// The library's constructors run.
unsafe fn open(path: &Path) -> Result<Library, String> {
    // SAFETY: the caller's promise.
    let opened = unsafe { unix::Library::open(Some(path), unix::RTLD_NOW | unix::RTLD_LOCAL) };
    opened.map(Into::into).map_err(|error| {
        error.source().map_or_else(|| error.to_string(), |source| source.to_string())
    })
}

/// A missing library that is in the FMU, which was linked without a path to its own folder.
fn missing_beside(why: &str, path: &Path) -> Option<PathBuf> {
    let (missing, _) = why.split_once(": cannot open shared object file")?;
    let file = path.with_file_name(Path::new(missing).file_name()?);
    file.is_file().then_some(file)
}

fn wants_python(why: &str) -> bool {
    why.split_once("undefined symbol: ")
        .is_some_and(|(_, symbol)| symbol.starts_with("Py") || symbol.starts_with("_Py"))
}

/// Maps Python's library for the lifetime of the process: an interpreter cannot be unloaded.
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
        "the FMU was made with Python, and no Python library was found: install one \
         (libpython3.x.so.1.0) or specify it with {VARIABLE}"
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
