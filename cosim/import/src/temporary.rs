//! Folders for unpacked archives: private (0700), unique, and removed with their value.
//!
//! A process that is killed cannot clean up. Each folder therefore contains a file that its process
//! keeps locked; the lock ends with the process, however it ends, and the next process that unpacks
//! something removes the folders that are not locked.

use std::ffi::{CString, OsString};
use std::fs::{self, File};
use std::io::{Error as IoError, ErrorKind};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::time::Duration;

use cosim_base::error::{Code, Error, Result};

const PREFIX: &str = "cosim-unpacked-";
const LOCK: &str = "lock";
const CONTENT: &str = "content";
/// Creating a folder and locking it takes less time than this.
const YOUNG: Duration = Duration::from_secs(60);

/// An unpacked archive.
pub struct Unpacked {
    content: PathBuf,
    _lock: File,
    _folder: Folder,
}

/// A folder that is removed with its value.
struct Folder(PathBuf);

impl Unpacked {
    /// A new and empty folder.
    pub fn new() -> Result<Self> {
        static SWEPT: Once = Once::new();
        SWEPT.call_once(|| sweep(&std::env::temp_dir()));
        Self::make().map_err(|e| {
            Error::new(Code::File, "no temporary folder can be created")
                .at(std::env::temp_dir())
                .why(e)
                .help("set TMPDIR to a writable folder on a file system that allows execution")
        })
    }

    fn make() -> std::io::Result<Self> {
        let folder = Folder::new()?;
        let lock = File::create_new(folder.0.join(LOCK))?;
        match lock.lock() {
            // A file system without locks: nothing there is ever removed.
            Err(e) if e.kind() == ErrorKind::Unsupported => (),
            locked => locked?,
        }
        let content = folder.0.join(CONTENT);
        fs::DirBuilder::new().mode(0o700).create(&content)?;
        Ok(Self { content, _lock: lock, _folder: folder })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.content
    }
}

impl Folder {
    /// Creates a private folder. The system chooses its name: generating a random name here would
    /// need a thread-local variable, and if this code is unloaded before the thread ends (it may be
    /// part of an FMU), its destructor would be gone.
    fn new() -> std::io::Result<Self> {
        let pattern = std::env::temp_dir().join(format!("{PREFIX}XXXXXX"));
        let pattern = CString::new(pattern.as_os_str().as_bytes())?.into_raw();
        // SAFETY: the text ends with a NUL and is written in place; its length stays.
        let made = unsafe { libc::mkdtemp(pattern) };
        let failed = made.is_null().then(IoError::last_os_error);
        // SAFETY: the pointer is that of `into_raw`.
        let name = unsafe { CString::from_raw(pattern) }.into_bytes();
        failed.map_or(Ok(Self(OsString::from_vec(name).into())), Err)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Whatever cannot be removed is left to the next cleanup.
        drop(fs::remove_dir_all(&self.0));
    }
}

/// Removes what killed processes of this user left in `folder`.
fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(PREFIX) && is_left(&entry.path()) {
            // Folders that cannot be removed belong to other users.
            drop(fs::remove_dir_all(entry.path()));
        }
    }
}

fn is_left(folder: &Path) -> bool {
    // SAFETY: always succeeds.
    let user = unsafe { libc::geteuid() };
    let own = |m: &fs::Metadata| m.uid() == user;
    let old = |m: &fs::Metadata| m.modified().is_ok_and(|t| t.elapsed().is_ok_and(|a| a > YOUNG));
    let lock = folder.join(LOCK);
    let is_folder = fs::symlink_metadata(folder).is_ok_and(|m| m.is_dir() && own(&m));
    let is_lock = fs::symlink_metadata(&lock).is_ok_and(|m| m.is_file() && own(&m) && old(&m));
    is_folder && is_lock && File::open(&lock).is_ok_and(|file| file.try_lock().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::SystemTime;
    use tempfile::TempDir;

    fn age(folder: &Path) {
        let lock = File::options().write(true).open(folder.join(LOCK)).unwrap();
        lock.set_modified(SystemTime::now() - 2 * YOUNG).unwrap();
    }

    #[test]
    fn only_what_is_left_is_swept() {
        let place = TempDir::new().unwrap();
        let make = |name: &str| {
            let folder = place.path().join(name);
            fs::create_dir_all(folder.join(CONTENT)).unwrap();
            File::create(folder.join(LOCK)).unwrap();
            folder
        };
        let (left, young) = (make("cosim-unpacked-left"), make("cosim-unpacked-young"));
        let (used, other) = (make("cosim-unpacked-used"), make("cosim-results"));
        [&left, &used, &other].iter().for_each(|folder| age(folder));
        let lock = File::open(used.join(LOCK)).unwrap();
        lock.lock().unwrap();
        sweep(place.path());
        let there = [&left, &young, &used, &other].map(|folder| folder.exists());
        assert_eq!(there, [false, true, true, true]);
    }
}
