//! Files that grow: what was flushed survives a power loss.

use std::fs::File;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

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
    pub(super) fn new(file: File, folder: Option<PathBuf>) -> Self {
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

pub(super) fn folder_of(target: &Path) -> PathBuf {
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new(".")).to_owned()
}

/// Waits until the entries of a folder are on the disk.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    synced(File::open(folder).and_then(|folder| folder.sync_all()))
}

/// Pipes, devices and some file systems have nothing to sync.
pub fn synced(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(why) if matches!(why.raw_os_error(), Some(libc::EINVAL | libc::ENOTSUP)) => Ok(()),
        other => other,
    }
}
