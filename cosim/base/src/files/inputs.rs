//! What a command reads: it is never replaced by what the same command writes.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Code, Error, Result};

/// The inputs of this process, for a program that never writes what it has read; otherwise none.
static INPUTS: Mutex<Option<HashMap<Identity, PathBuf>>> = Mutex::new(None);

/// Device and number of a file: the same by every name that it has.
type Identity = (u64, u64);

pub(super) fn identity(path: &Path) -> Option<Identity> {
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
pub fn note_continued(file: &Path) {
    if let (Some(inputs), Some(identity)) = (&mut *inputs(), identity(file)) {
        inputs.remove(&identity);
    }
}

/// Most octets of an input without a size: a pipe or a device.
const UNSIZED: u64 = 1 << 30;

/// Opens an input. A pipe that nothing writes to is empty: it is not waited for.
pub fn open_input(file: &Path) -> io::Result<File> {
    note_input(file);
    let opened = OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK).open(file)?;
    let flags = rustix::fs::fcntl_getfl(&opened)?;
    rustix::fs::fcntl_setfl(&opened, flags - rustix::fs::OFlags::NONBLOCK)?;
    Ok(opened)
}

/// The content of an input.
pub fn read_input(file: &Path) -> io::Result<Vec<u8>> {
    let opened = open_input(file)?;
    let whole = opened.metadata()?.is_file();
    read_to(opened, if whole { u64::MAX } else { UNSIZED })
}

/// The content of an input that is a text.
pub fn read_input_text(file: &Path) -> io::Result<String> {
    let text = String::from_utf8(read_input(file)?);
    text.map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8"))
}

/// The content of a file of at most so many octets.
fn read_to(file: File, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(file.metadata()?.len().min(most) as usize)?;
    if file.take(most.saturating_add(1)).read_to_end(&mut bytes)? as u64 > most {
        return Err(io::Error::other(format!("it has more than {most} octets")));
    }
    Ok(bytes)
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
    read_to(file, most).map(Some)
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

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

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
        let made = std::process::Command::new("mkfifo").arg(path("pipe")).status().unwrap();
        assert!(made.success());
        assert_eq!(read_foreign(&path("plain"), 4).unwrap(), Some(b"text".to_vec()));
        assert!(read_foreign(&path("plain"), 3).is_err());
        assert!(read_foreign(&path("missing"), 4).is_err());
        for other in ["link", "pipe", "."] {
            assert_eq!(read_foreign(&path(other), 4).unwrap(), None, "{other}");
        }
    }
}
