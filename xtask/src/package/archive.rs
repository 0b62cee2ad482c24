//! Zip files: written by the kit, read back completely for merging.

use anyhow::{Context, Error, Result};
use std::{fs::File, io::Read, path::Path};
use zip::ZipArchive;

pub(crate) use fmu_kit::package::File as Entry;

/// Writes a zip file, the same bytes every time.
pub(crate) fn write(path: &Path, files: &[Entry]) -> Result<()> {
    fmu_kit::package::write(path, files).map_err(Error::msg)
}

/// Reads all files of a zip file, in its order.
pub(crate) fn read(path: &Path) -> Result<Vec<Entry>> {
    let named = || path.display().to_string();
    let file = File::open(path).with_context(named)?;
    let mut zip = ZipArchive::new(file).with_context(named)?;
    let mut files = Vec::new();
    for index in 0..zip.len() {
        let mut entry = zip.by_index(index).with_context(named)?;
        if entry.is_file() {
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).with_context(named)?;
            files.push((entry.name().with_context(named)?.into_owned(), bytes));
        }
    }
    Ok(files)
}
