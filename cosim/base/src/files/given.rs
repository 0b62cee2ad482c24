//! Files of a confined process: opened by the process that confined it, which also gives complete
//! files their names.
#![allow(unsafe_code, reason = "inherited file descriptors")]

use std::ffi::OsString;
use std::fs::File;
use std::os::fd::RawFd;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Files that were opened by the process that confined this one, which may not open any itself.
struct Given {
    files: Vec<(PathBuf, RawFd)>,
    /// Where complete files are left for that process.
    folder: PathBuf,
}

static GIVEN: OnceLock<Given> = OnceLock::new();

/// From now on, these files are written through the given descriptors, and files that are replaced
/// as a whole are left in `folder` for the parent process, under their [`outbox_name`].
pub fn give(files: Vec<(PathBuf, RawFd)>, folder: PathBuf) {
    // Once per process.
    drop(GIVEN.set(Given { files, folder }));
}

/// The folder where complete files are left.
pub(super) fn outbox() -> Option<&'static Path> {
    GIVEN.get().map(|given| given.folder.as_path())
}

/// The descriptor for a file.
pub(super) fn given(target: &Path) -> Option<File> {
    let given = GIVEN.get()?;
    let (_, file) = given.files.iter().find(|(path, _)| path == target)?;
    // SAFETY: the descriptor was opened for this process and is never closed.
    let borrowed = unsafe { std::os::fd::BorrowedFd::borrow_raw(*file) };
    borrowed.try_clone_to_owned().ok().map(File::from)
}

/// The name in the folder of [`give`] of a file that was replaced as a whole; it contains no `/`.
pub fn outbox_name(target: &Path) -> String {
    target.as_os_str().as_bytes().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The file with such a name.
pub fn of_outbox(name: &str) -> Option<PathBuf> {
    let digits = name.as_bytes().chunks(2);
    let bytes: Option<Vec<u8>> =
        digits.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect();
    Some(OsString::from_vec(bytes?).into())
}

/// In that folder: the continued results are in the new file.
pub const CONTINUED: &str = "continued";
