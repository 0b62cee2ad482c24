//! Writes files: never replacing something else, completely or not at all, and safe against power
//! loss.
//!
//! A file that replaces another as a whole is written to a file without a name, synced, and only
//! then gets the name, which is synced with its folder. A process that is killed therefore leaves
//! either the old file or the new one. File systems without unnamed files get a hidden one, locked
//! by its writer; the next process that writes there removes those that are no longer locked.
#![allow(unsafe_code, reason = "system calls without a safe form")]

use std::collections::HashMap;
use std::ffi::{CString, OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::os::fd::{AsRawFd, RawFd};
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use crate::error::{Code, Error, Result};

/// Extension of hidden files that are being written: `.NAME.PROCESS-NUMBER.unfinished`.
const UNFINISHED: &str = ".unfinished";

/// First bytes of files that are not results, and what they are.
const OTHERS: [(&[u8], &str); 6] = [
    (b"PK\x03\x04", "an archive (.fmu, .ssp)"),
    (b"PK\x05\x06", "an archive"),
    (b"<", "an XML file"),
    (b"{", "a JSON file"),
    (b"\x7fELF", "a program or library"),
    (b"-----BEGIN", "a certificate or key"),
];
const SNAPSHOT: (&[u8], &str) = (b"COSIMSNP", "a snapshot");

/// Creates a file for results, digests or a log, emptying an existing one; `what` is the error
/// message. A file that is clearly something else is never replaced.
pub fn create(target: &Path, what: &str) -> Result<Durable> {
    let folder = given(target).is_none().then(|| folder_of(target));
    Ok(Durable::new(create_plain(target, what)?, folder))
}

/// The same for a log, which is not worth syncing.
pub fn create_plain(target: &Path, what: &str) -> Result<File> {
    let file = create_later(target, what)?;
    begin(target, &file)?;
    Ok(file)
}

/// A file as by [`create_plain`], but an existing one keeps its content until [`begin`].
pub fn create_later(target: &Path, what: &str) -> Result<File> {
    if let Some(file) = given(target) {
        return Ok(file);
    }
    refuse_others(target, what, Some(SNAPSHOT))?;
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(target);
    file.map_err(|why| Error::new(Code::Output, what).at(target).why(why))
}

/// Empties a file of [`create_later`], unless it is an input.
pub fn begin(target: &Path, file: &File) -> Result<()> {
    refuse_inputs(target, [])?;
    // Devices and pipes have no length.
    let plain = file.metadata().is_ok_and(|metadata| metadata.is_file());
    let emptied = if plain && given(target).is_none() { file.set_len(0) } else { Ok(()) };
    emptied
        .map_err(|why| Error::new(Code::Output, "the file cannot be emptied").at(target).why(why))
}

/// Refuses a name if there is a file of another kind; `more` is an additional kind to refuse.
pub fn refuse_others(target: &Path, what: &str, more: Option<(&[u8], &str)>) -> Result<()> {
    if !target.metadata().is_ok_and(|metadata| metadata.is_file()) {
        return Ok(());
    }
    let mut begin = [0; 16];
    let read = File::open(target).and_then(|mut file| file.read(&mut begin)).unwrap_or(0);
    let begin = begin[..read].trim_ascii_start();
    let html = begin.get(..14).is_some_and(|b| b.eq_ignore_ascii_case(b"<!doctype html"));
    match OTHERS.into_iter().chain(more).find(|(start, _)| begin.starts_with(start)) {
        Some((_, kind)) if !html => Err(Error::new(Code::Output, what)
            .at(target)
            .why(format!("the existing file is {kind}, which would be lost"))
            .help("choose another name, or remove the file")),
        _ => Ok(()),
    }
}

/// The inputs of this process, for a program that never writes what it has read; otherwise none.
static INPUTS: Mutex<Option<HashMap<Identity, PathBuf>>> = Mutex::new(None);

/// Device and number of a file: the same by every name that it has.
type Identity = (u64, u64);

fn identity(path: &Path) -> Option<Identity> {
    path.metadata().ok().filter(fs::Metadata::is_file).map(|m| (m.dev(), m.ino()))
}

fn inputs() -> MutexGuard<'static, Option<HashMap<Identity, PathBuf>>> {
    INPUTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on, this process does not write to files that it has read as inputs: for programs that
/// do one thing and end.
pub fn protect_inputs() {
    inputs().get_or_insert_default();
}

/// Notes that a file is an input, if it exists.
pub fn note_input(file: &Path) {
    if let (Some(inputs), Some(identity)) = (&mut *inputs(), identity(file)) {
        inputs.insert(identity, file.to_owned());
    }
}

/// Notes that a file that was read is continued: it may be replaced.
pub(crate) fn note_continued(file: &Path) {
    if let (Some(inputs), Some(identity)) = (&mut *inputs(), identity(file)) {
        inputs.remove(&identity);
    }
}

/// Opens an input.
pub fn open_input(file: &Path) -> io::Result<File> {
    note_input(file);
    File::open(file)
}

/// The content of an input.
pub fn read_input(file: &Path) -> io::Result<Vec<u8>> {
    note_input(file);
    fs::read(file)
}

/// The content of an input that is a text.
pub fn read_input_text(file: &Path) -> io::Result<String> {
    note_input(file);
    fs::read_to_string(file)
}

/// The content of a file in a folder where others write: nothing if it is not a plain file, such as a
/// link to what they may not read. A file above `most` octets is an error.
pub fn read_foreign(file: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
    let mut options = OpenOptions::new();
    let opened = options.read(true).custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK).open(file);
    let file = match opened {
        Ok(file) if file.metadata()?.is_file() => file,
        Ok(_) => return Ok(None),
        Err(why) if why.raw_os_error() == Some(libc::ELOOP) => return Ok(None),
        Err(why) => return Err(why),
    };
    let mut bytes = Vec::new();
    if file.take(most + 1).read_to_end(&mut bytes)? as u64 > most {
        return Err(io::Error::other(format!("it has more than {most} octets")));
    }
    Ok(Some(bytes))
}

/// Refuses a name that belongs to an input of this process, or to one of these.
pub fn refuse_inputs<'a>(target: &Path, more: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    let Some(there) = identity(target) else { return Ok(()) };
    let input = more.into_iter().find(|input| identity(input) == Some(there)).map(Path::to_owned);
    let known = || inputs().as_ref()?.get(&there).cloned();
    // The number of a file that is gone may be that of another one by now.
    match input.or_else(known).filter(|input| identity(input) == Some(there)) {
        Some(input) => Err(Error::new(Code::Usage, "the output would replace an input")
            .at(target)
            .why(format!("{} is read by this command", input.display()))
            .help("choose another name for the output")),
        None => Ok(()),
    }
}

/// Copies a file, replacing another one as a whole; a file is never copied onto itself.
pub fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if identity(from).is_some() && identity(from) == identity(to) {
        return Ok(());
    }
    let unfinished = Unfinished::new(to)?;
    io::copy(&mut File::open(from)?, &mut unfinished.file())?;
    unfinished.finish()
}

/// A file whose content survives a power loss once it is flushed. What was written but not flushed
/// is in a buffer that [`save_all`] finds.
pub struct Durable {
    shared: Arc<Mutex<Buffered>>,
    /// The folder, until its entry has been synced.
    folder: Option<PathBuf>,
}

struct Buffered {
    file: File,
    buffer: Vec<u8>,
}

/// Bytes written at once.
const PIECE: usize = 1 << 16;

/// The files that are being written.
static OPEN: Mutex<Vec<Weak<Mutex<Buffered>>>> = Mutex::new(Vec::new());

/// Flushes all buffers that are not in use: for a process that ends without returning to the
/// writers.
pub fn save_all() {
    let open = OPEN.try_lock();
    for file in open.iter().flat_map(|open| open.iter()).filter_map(Weak::upgrade) {
        if let Ok(mut file) = file.try_lock() {
            // If this flush fails there is no channel left to report it.
            drop(file.save());
        }
    }
}

impl Durable {
    fn new(file: File, folder: Option<PathBuf>) -> Self {
        let shared = Arc::new(Mutex::new(Buffered { file, buffer: Vec::new() }));
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        open.retain(|file| file.strong_count() > 0);
        open.push(Arc::downgrade(&shared));
        Self { shared, folder }
    }

    fn buffered(&self) -> MutexGuard<'_, Buffered> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Buffered {
    fn save(&mut self) -> io::Result<()> {
        let saved = self.file.write_all(&self.buffer);
        self.buffer.clear();
        saved
    }
}

impl Write for Durable {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut own = self.buffered();
        own.buffer.extend_from_slice(bytes);
        if own.buffer.len() >= PIECE {
            own.save()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let mut own = self.buffered();
        own.save()?;
        synced(own.file.sync_data())?;
        drop(own);
        match self.folder.take() {
            Some(folder) => sync_folder(&folder),
            None => Ok(()),
        }
    }
}

impl Seek for Durable {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        let mut own = self.buffered();
        own.save()?;
        own.file.seek(to)
    }
}

impl Drop for Durable {
    fn drop(&mut self) {
        // A caller that needs to know whether it can be written flushes it.
        drop(self.buffered().save());
    }
}

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

/// The descriptor for a file.
fn given(target: &Path) -> Option<File> {
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

    /// Its current path.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// A second handle for writing.
    pub fn writer(&self) -> io::Result<Durable> {
        Ok(Durable::new(self.file.try_clone()?, None))
    }

    /// Gives the file its name, replacing an existing one.
    pub fn finish(self) -> io::Result<()> {
        if let Some(given) = GIVEN.get().filter(|_| given(&self.target).is_some()) {
            synced(self.file.sync_all())?;
            return fs::write(given.folder.join(CONTINUED), b"");
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
    if let Some(given) = GIVEN.get() {
        // Under its final name once complete; the parent process keeps it.
        let (begun, whole) = (given.folder.join("begun"), given.folder.join(outbox_name(target)));
        return fs::write(&begun, bytes).and_then(|()| fs::rename(begun, whole));
    }
    let unfinished = Unfinished::new(target)?;
    unfinished.file().write_all(bytes)?;
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

fn folder_of(target: &Path) -> PathBuf {
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new(".")).to_owned()
}

pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    synced(File::open(folder).and_then(|folder| folder.sync_all()))
}

/// Pipes, devices and some file systems have nothing to sync.
pub(crate) fn synced(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(why) if matches!(why.raw_os_error(), Some(libc::EINVAL | libc::ENOTSUP)) => Ok(()),
        other => other,
    }
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

    #[test]
    fn what_is_something_else_is_not_replaced() {
        let folder = TempDir::new().unwrap();
        let target = folder.path().join("a");
        for (content, replaced) in [
            (&b"PK\x03\x04..."[..], false),
            (b"\n <?xml", false),
            (b"{\"events\"", false),
            (b"COSIMSNP...", false),
            (b"-----BEGIN PRIVATE KEY", false),
            (b"time,a\n", true),
            (b"<!doctype html>", true),
            (b"", true),
        ] {
            fs::write(&target, content).unwrap();
            let created = create(&target, "it cannot be written");
            assert_eq!(created.is_ok(), replaced, "{}", String::from_utf8_lossy(content));
            assert_eq!(fs::read(&target).unwrap().is_empty(), replaced);
        }
    }

    #[test]
    fn an_input_is_known_by_every_name_it_has() {
        let folder = TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("input"), "x").unwrap();
        fs::hard_link(path("input"), path("hard")).unwrap();
        std::os::unix::fs::symlink(path("input"), path("soft")).unwrap();
        fs::write(path("other"), "x").unwrap();
        let input = path("input");
        for (name, allowed) in
            [("input", false), ("hard", false), ("soft", false), ("other", true), ("new", true)]
        {
            let refused = refuse_inputs(&path(name), [input.as_path()]);
            assert_eq!(refused.is_ok(), allowed, "{name}");
        }
    }

    #[test]
    fn of_foreign_files_only_plain_and_small_ones_are_read() {
        let folder = TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("plain"), "text").unwrap();
        std::os::unix::fs::symlink(path("plain"), path("link")).unwrap();
        let pipe = CString::new(path("pipe").as_os_str().as_bytes()).unwrap();
        // SAFETY: the name is a C string that lives until the call returns.
        assert_eq!(unsafe { libc::mkfifo(pipe.as_ptr(), 0o600) }, 0);
        assert_eq!(read_foreign(&path("plain"), 4).unwrap(), Some(b"text".to_vec()));
        assert!(read_foreign(&path("plain"), 3).is_err());
        assert!(read_foreign(&path("missing"), 4).is_err());
        for other in ["link", "pipe", "."] {
            assert_eq!(read_foreign(&path(other), 4).unwrap(), None, "{other}");
        }
    }
}
