//! Zip files: the same bytes every time, and read back whole.

use anyhow::{Context, Result};
use std::{
    fs::{self, File},
    io::{Read, Write},
    path::Path,
};
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter, write::SimpleFileOptions};

/// A file in an archive: its name with `/` between folders, and its bytes.
pub(crate) type Entry = (String, Vec<u8>);

/// Writes a zip file with fixed times and permissions, so that equal input gives equal bytes. It
/// appears under its name when it is whole: somebody may be reading the old one.
pub(crate) fn write(path: &Path, files: &[Entry]) -> Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let partial = path.with_extension("partial");
    let file = File::create(&partial).with_context(|| partial.display().to_string())?;
    let mut zip = ZipWriter::new(file);
    for (name, bytes) in files {
        zip.start_file(name.as_str(), options)?;
        zip.write_all(bytes)?;
    }
    zip.finish()?;
    fs::rename(&partial, path).with_context(|| path.display().to_string())
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
