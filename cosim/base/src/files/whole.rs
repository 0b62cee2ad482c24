//! Files that replace others as a whole: completely or not at all.
//!
//! Such a file is written to a file without a name, synced, and only then gets the name, which is
//! synced with its folder. A process that is killed therefore leaves either the old file or the new
//! one. File systems without unnamed files get a hidden one, locked by its writer; the next process
//! that writes there removes those that are no longer locked.
#![allow(unsafe_code, reason = "a system call without a safe form")]

use std::ffi::{CString, OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use super::durable::{Durable, folder_of, sync_folder, synced};
use super::given::{CONTINUED, given, outbox, outbox_name};
use super::inputs::{identity, refuse_inputs};

/// Extension of hidden files that are being written: `.NAME.PROCESS-NUMBER.unfinished`.
const UNFINISHED: &str = ".unfinished";

/// Copies a file, replacing another one as a whole; a file is never copied onto itself.
pub fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if identity(from).is_some() && identity(from) == identity(to) {
        return Ok(());
    }
    let unfinished = Unfinished::new(to)?;
    io::copy(&mut File::open(from)?, &mut unfinished.file())?;
    unfinished.finish()
}

/// A file that gets its name only when it is complete.
pub struct Unfinished {
    file: File,
    target: PathBuf,
    /// If the file system does not support unnamed files.
    hidden: Option<Hidden>,
}

/// A file that is removed with its value.
struct Hidden(PathBuf);

impl Drop for Hidden {
    fn drop(&mut self) {
        // It no longer exists if it has got its final name.
        drop(fs::remove_file(&self.0));
    }
}

impl Unfinished {
    /// For `target`, whose folder must exist.
    pub fn new(target: &Path) -> io::Result<Self> {
        refuse_inputs(target, []).map_err(|refused| io::Error::other(refused.line()))?;
        if let Some(file) = given(target) {
            return Ok(Self { file, target: target.to_owned(), hidden: None });
        }
        let folder = folder_of(target);
        sweep(&folder, target);
        let nameless = OpenOptions::new()
            .read(true)
            .write(true)
            .mode(0o600)
            .custom_flags(libc::O_TMPFILE)
            .open(&folder);
        let (file, hidden) = match nameless {
            Ok(file) => (file, None),
            Err(why) if is_unknown(&why) => {
                let hidden = Hidden(hidden(&folder, target));
                let mut options = OpenOptions::new();
                options.read(true).write(true).create_new(true).mode(0o600);
                (options.open(&hidden.0)?, Some(hidden))
            }
            Err(why) => return Err(why),
        };
        match file.try_lock() {
            Err(fs::TryLockError::Error(why)) if why.kind() != io::ErrorKind::Unsupported => {
                return Err(why);
            }
            _ => (),
        }
        Ok(Self { file, target: target.to_owned(), hidden })
    }

    /// The file.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// A second handle for writing.
    pub fn writer(&self) -> io::Result<Durable> {
        Ok(Durable::new(self.file.try_clone()?, None))
    }

    /// Gives the file its name, replacing an existing one.
    pub fn finish(self) -> io::Result<()> {
        if let Some(outbox) = outbox().filter(|_| given(&self.target).is_some()) {
            synced(self.file.sync_all())?;
            return fs::write(outbox.join(CONTINUED), b"");
        }
        let folder = folder_of(&self.target);
        // With the permissions of the file it replaces, or of a new file.
        let mode = fs::metadata(&self.target).map_or(0o666 & !umask(), |there| there.mode());
        self.file.set_permissions(fs::Permissions::from_mode(mode & 0o777))?;
        synced(self.file.sync_all())?;
        let named = match self.hidden {
            Some(hidden) => hidden,
            None => {
                let hidden = Hidden(hidden(&folder, &self.target));
                link(&self.file, &hidden.0)?;
                hidden
            }
        };
        fs::rename(&named.0, &self.target)?;
        std::mem::forget(named);
        sync_folder(&folder)
    }
}

/// Replaces `target` by these bytes, or leaves it unchanged.
pub fn replace(target: &Path, bytes: &[u8]) -> io::Result<()> {
    replace_by(target, |mut file| file.write_all(bytes))
}

/// Replaces `target` by what is written to a file, or leaves it unchanged.
pub fn replace_by(target: &Path, write: impl FnOnce(&File) -> io::Result<()>) -> io::Result<()> {
    if let Some(outbox) = outbox() {
        // Under its final name once complete; the parent process keeps it.
        let (begun, whole) = (outbox.join("begun"), outbox.join(outbox_name(target)));
        write(&File::create(&begun)?)?;
        return fs::rename(begun, whole);
    }
    let unfinished = Unfinished::new(target)?;
    write(unfinished.file())?;
    unfinished.finish()
}

/// Removes files that killed processes left beside `target`.
fn sweep(folder: &Path, target: &Path) {
    let prefix = hidden_prefix(target);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let bytes = name.as_bytes();
        let ours = bytes.starts_with(prefix.as_bytes()) && bytes.ends_with(UNFINISHED.as_bytes());
        let plain = entry.file_type().is_ok_and(|kind| kind.is_file());
        if ours && plain && File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok()) {
            // Files that cannot be removed belong to other users.
            drop(fs::remove_file(entry.path()));
        }
    }
}

fn hidden_prefix(target: &Path) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(target.file_name().unwrap_or(OsStr::new("file")));
    prefix.push(".");
    prefix
}

/// A unique name: from the process id, and a number used only once.
fn hidden(folder: &Path, target: &Path) -> PathBuf {
    static NUMBER: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
    let number = NUMBER.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let mut name = hidden_prefix(target);
    name.push(format!("{}-{number}{UNFINISHED}", std::process::id()));
    folder.join(name)
}

/// Gives a name to an unnamed file.
fn link(file: &File, name: &Path) -> io::Result<()> {
    let from = CString::new(format!("/proc/self/fd/{}", file.as_raw_fd()))?;
    let to = CString::new(name.as_os_str().as_bytes())?;
    let (here, follow) = (libc::AT_FDCWD, libc::AT_SYMLINK_FOLLOW);
    // SAFETY: both are C strings that live until the call returns.
    match unsafe { libc::linkat(here, from.as_ptr(), here, to.as_ptr(), follow) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

fn umask() -> u32 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("Umask:"));
    line.and_then(|mask| u32::from_str_radix(mask.trim(), 8).ok()).unwrap_or(0o077)
}

/// Whether a file system does not support unnamed files.
fn is_unknown(why: &io::Error) -> bool {
    matches!(why.raw_os_error(), Some(libc::EOPNOTSUPP | libc::EISDIR | libc::EINVAL))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    fn names(folder: &TempDir) -> Vec<String> {
        let entries = fs::read_dir(folder.path()).unwrap().flatten();
        let mut names: Vec<String> =
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_has_its_name_only_when_it_is_whole_and_leftovers_go() {
        let folder = TempDir::new().unwrap();
        let target = folder.path().join("a");
        fs::write(&target, "old").unwrap();
        // Of a process that was killed, and of one that is writing.
        fs::write(folder.path().join(".a.1-0.unfinished"), "cut").unwrap();
        let busy = File::create(folder.path().join(".a.2-0.unfinished")).unwrap();
        busy.lock().unwrap();
        fs::write(folder.path().join(".ab.1-0.unfinished"), "another's").unwrap();
        let unfinished = Unfinished::new(&target).unwrap();
        unfinished.file().write_all(b"new").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"old");
        let others = [".a.2-0.unfinished", ".ab.1-0.unfinished"];
        unfinished.finish().unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert_eq!(names(&folder), [others[0], others[1], "a"]);
        drop(Unfinished::new(&target).unwrap());
        assert_eq!(names(&folder), [others[0], others[1], "a"]);
    }

    #[test]
    fn a_hidden_file_does_where_there_are_none_without_a_name() {
        let folder = TempDir::new().unwrap();
        let target = folder.path().join("a");
        let of = || {
            let hidden = Hidden(hidden(folder.path(), &target));
            let file = File::create(&hidden.0).unwrap();
            Unfinished { file, target: target.clone(), hidden: Some(hidden) }
        };
        drop(of());
        assert!(names(&folder).is_empty());
        of().finish().unwrap();
        assert_eq!(names(&folder), ["a"]);
    }
}
