//! The FMUs of all systems made from one file, so that `System::with` opens none of them again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::Result;
use crate::fmi::Fmu;

/// FMUs by the path under which they were requested.
#[derive(Default)]
pub(super) struct OpenedFmus(Mutex<BTreeMap<PathBuf, Arc<Fmu>>>);

impl OpenedFmus {
    /// The FMU at `path`, opened on the first request.
    pub(super) fn open(&self, path: &Path) -> Result<Arc<Fmu>> {
        let mut opened = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(fmu) = opened.get(path) {
            return Ok(fmu.clone());
        }
        let fmu = Fmu::open(path)?;
        opened.insert(path.to_owned(), fmu.clone());
        Ok(fmu)
    }
}
