//! The file of an exported FMU: with fixed times and permissions, so that the same content gives
//! the same bytes, and under its final name only when it is complete.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use cosim_base::error::{Code, Error, Result};
use cosim_base::files::{Unfinished, read_input};
use cosim_base::sha256;

/// Path in the archive, with `/` as separator, and content.
pub type Entry = (String, Content);

/// The content of an entry.
pub struct Content {
    what: What,
    digest: String,
}

enum What {
    Bytes(Vec<u8>),
    /// An FMU, which is already compressed.
    File(PathBuf),
}

impl Content {
    /// From memory.
    pub fn bytes(bytes: impl Into<Vec<u8>>) -> Self {
        let bytes = bytes.into();
        Self { digest: sha256(&bytes), what: What::Bytes(bytes) }
    }

    /// From a file, which is read again when it is packed.
    pub fn file(path: PathBuf) -> Result<Self> {
        let bytes = read_input(&path)
            .map_err(|e| Error::new(Code::File, "the FMU cannot be read").at(&path).why(e))?;
        Ok(Self { digest: sha256(bytes), what: What::File(path) })
    }

    /// SHA-256 as hexadecimal text.
    pub fn digest(&self) -> &str {
        &self.digest
    }
}

/// Writes the archive.
pub fn write(path: &Path, entries: &[Entry]) -> Result<()> {
    let unwritten = |e: &dyn std::fmt::Display| {
        Error::new(Code::Output, "the FMU cannot be written").at(path).why(e)
    };
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(|e| unwritten(&e))?;
    let unfinished = Unfinished::new(path).map_err(|e| unwritten(&e))?;
    pack(unfinished.file(), entries).map_err(|e| unwritten(&e))?;
    unfinished.finish().map_err(|e| unwritten(&e))
}

fn pack(file: &File, entries: &[Entry]) -> Result<(), ZipError> {
    let mut zip = ZipWriter::new(file);
    let options = SimpleFileOptions::default()
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    for (name, content) in entries {
        let method = match content.what {
            What::Bytes(_) => CompressionMethod::Deflated,
            What::File(_) => CompressionMethod::Stored,
        };
        zip.start_file(name.as_str(), options.compression_method(method))?;
        match &content.what {
            What::Bytes(bytes) => zip.write_all(bytes)?,
            What::File(path) => drop(std::io::copy(&mut File::open(path)?, &mut zip)?),
        }
    }
    zip.finish()?;
    Ok(())
}
