//! The archives of all systems made from one file: `System::with` opens no FMU again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cosim_base::error::Result;
use cosim_import::Fmu;
use cosim_import::archive::{self, Room, Unpacked};

/// FMUs by the path under which they were requested, and the room that is left for archives.
#[derive(Default)]
pub(super) struct OpenedFmus {
    /// The FMUs of the file are unpacked.
    unpacked: bool,
    opened: Mutex<Opened>,
}

#[derive(Default)]
struct Opened {
    /// Also those that could not be opened, so that none is unpacked for each of its components.
    fmus: BTreeMap<PathBuf, Result<Arc<Fmu>>>,
    room: Room,
}

impl OpenedFmus {
    pub(super) fn new(unpacked: bool) -> Self {
        Self { unpacked, ..Self::default() }
    }

    /// The FMU at `path`, opened on the first request.
    pub(super) fn open(&self, path: &Path) -> Result<Arc<Fmu>> {
        let mut opened = self.lock();
        if let Some(fmu) = opened.fmus.get(path) {
            return fmu.clone();
        }
        let fmu = match self.unpacked {
            true => Fmu::open_unpacked(path),
            false => Fmu::open_within(path, &mut opened.room),
        };
        opened.fmus.insert(path.to_owned(), fmu.clone());
        fmu
    }

    /// Unpacks a package.
    pub(super) fn unpack(&self, path: &Path) -> Result<Unpacked> {
        archive::unpack_within(path, |_| true, &mut self.lock().room)
    }

    /// Tries to open all others again when they are requested: files may be corrected.
    pub(super) fn forget_failures(&self) {
        self.lock().fmus.retain(|_, fmu| fmu.is_ok());
    }

    fn lock(&self) -> MutexGuard<'_, Opened> {
        self.opened.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
