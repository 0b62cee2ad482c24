//! The last FMI call of a process, stored so that it outlives the process.
//!
//! An FMU that crashes takes its process with it, and one in an endless loop answers no one. Before
//! each call, its name, the instance and the time of the instance are therefore stored in a
//! memory-mapped file: a few stores, no system call, and the supervisor of the process reads the
//! file after its death.

use std::fs::File;
use std::os::fd::AsRawFd;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::Mutex;

use cosim_base::files;
use cosim_base::time::Time;

/// In octets: the mark, the time, then function and instance, each preceded by its length.
const SIZE: usize = 256;
const MARK: u8 = 0xCA;
const FUNCTION: usize = 16;
const INSTANCE: usize = 80;

/// The file for calls.
#[derive(Debug)]
pub struct LastCall {
    page: Mutex<Page>,
}

#[derive(Debug)]
struct Page(NonNull<[u8; SIZE]>);

// SAFETY: the memory belongs to this value alone, whichever thread has it.
unsafe impl Send for Page {}

/// The last recorded call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Noted {
    /// The function, such as `fmi2DoStep`.
    pub function: String,
    /// The instance.
    pub instance: String,
    /// The time of the instance, at which its step begins.
    pub time: Time,
    /// The call has not returned.
    pub inside: bool,
}

impl LastCall {
    /// Records calls in `file`, which is created.
    pub fn create(file: impl AsRef<Path>) -> std::io::Result<Self> {
        let file = File::options().read(true).write(true).create(true).truncate(true).open(file)?;
        file.set_len(SIZE as u64)?;
        let (access, how) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_SHARED);
        // SAFETY: a new mapping of a file that is open and as long as the mapping.
        let page =
            unsafe { libc::mmap(std::ptr::null_mut(), SIZE, access, how, file.as_raw_fd(), 0) };
        match NonNull::new(page.cast::<[u8; SIZE]>()) {
            Some(own) if page != libc::MAP_FAILED => Ok(Self { page: Mutex::new(Page(own)) }),
            _ => Err(std::io::Error::last_os_error()),
        }
    }

    /// Before a call.
    pub(super) fn begin(&self, instance: &str, function: &str, time: Time) {
        self.write(|page| {
            page[0] = MARK;
            page[1] = 1;
            page[8..16].copy_from_slice(&time.ns().to_le_bytes());
            put(&mut page[FUNCTION..INSTANCE], function);
            put(&mut page[INSTANCE..], instance);
        });
    }

    /// After it.
    pub(super) fn end(&self) {
        self.write(|page| page[1] = 0);
    }

    fn write(&self, write: impl FnOnce(&mut [u8; SIZE])) {
        // If a dead thread holds the lock, the file is no longer used.
        if let Ok(mut page) = self.page.lock() {
            // SAFETY: `SIZE` octets are mapped there until the drop; only the holder of the lock
            // has a reference, and readers are other processes that read the file.
            write(unsafe { page.0.as_mut() });
        }
    }

    /// The call recorded in `file`.
    pub fn read(file: impl AsRef<Path>) -> Option<Noted> {
        let bytes = files::read_foreign(file.as_ref(), SIZE as u64).ok()??;
        let page: &[u8; SIZE] = bytes.first_chunk()?;
        let time = i64::from_le_bytes(*page[8..16].first_chunk()?);
        (page[0] == MARK).then(|| Noted {
            function: get(&page[FUNCTION..INSTANCE]),
            instance: get(&page[INSTANCE..]),
            time: Time::from_ns(time),
            inside: page[1] == 1,
        })
    }
}

impl Drop for LastCall {
    fn drop(&mut self) {
        let page = self.page.get_mut().map(|page| page.0.as_ptr().cast());
        if let Ok(page) = page {
            // SAFETY: mapped by `create` with this size, and nothing refers to it any more.
            unsafe { libc::munmap(page, SIZE) };
        }
    }
}

/// A text, truncated to the buffer.
fn put(buffer: &mut [u8], text: &str) {
    let length = text.len().min(buffer.len() - 1).min(usize::from(u8::MAX));
    buffer[0] = length as u8;
    buffer[1..=length].copy_from_slice(&text.as_bytes()[..length]);
}

fn get(buffer: &[u8]) -> String {
    let text = buffer.get(1..=usize::from(buffer[0])).unwrap_or_default();
    String::from_utf8_lossy(text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_noted_is_in_the_file_at_once() {
        let folder = tempfile::TempDir::new().unwrap();
        let file = folder.path().join("last");
        let last = LastCall::create(&file).unwrap();
        assert_eq!(LastCall::read(&file), None);
        let time = Time::from_ns(-5);
        last.begin("a.b", "fmi2DoStep", time);
        let noted = LastCall::read(&file).unwrap();
        assert_eq!((noted.function.as_str(), noted.instance.as_str()), ("fmi2DoStep", "a.b"));
        assert!(noted.inside && noted.time == time);
        last.end();
        assert!(!LastCall::read(&file).unwrap().inside);
        last.begin(&"ä".repeat(500), "fmi2GetReal", time);
        assert_eq!(LastCall::read(&file).unwrap().function, "fmi2GetReal");
    }
}
