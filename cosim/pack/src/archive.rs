//! The files of an exported FMU.

use std::fs;
use std::path::{Path, PathBuf};

use cosim_base::error::{Code, Error, Result};
use cosim_base::files::read_input;
use cosim_base::sha256;
use cosim_import::archive;

/// Path in the archive, with `/` as separator, and content.
pub type Entry = (String, Content);

/// The content of an entry.
pub struct Content {
    what: What,
    digest: String,
}

enum What {
    Bytes(Vec<u8>),
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
            .map_err(|e| Error::new(Code::File, "the file cannot be read").at(&path).why(e))?;
        Ok(Self { digest: sha256(bytes), what: What::File(path) })
    }

    /// SHA-256 as hexadecimal text.
    pub fn digest(&self) -> &str {
        &self.digest
    }
}

/// The files in a folder and its subfolders, by relative path.
pub fn files(folder: &Path) -> Result<Vec<Entry>> {
    let unread =
        |why| Error::new(Code::File, "an unpacked file cannot be read").at(folder).why(why);
    let mut found = Vec::new();
    let mut folders = vec![(String::new(), folder.to_owned())];
    while let Some((above, folder)) = folders.pop() {
        for entry in fs::read_dir(folder).map_err(unread)? {
            let entry = entry.map_err(unread)?;
            let name = format!("{above}{}", entry.file_name().to_string_lossy());
            match entry.file_type().map_err(unread)?.is_dir() {
                true => folders.push((name + "/", entry.path())),
                false => found.push((name, Content::file(entry.path())?)),
            }
        }
    }
    found.sort_by(|(a, _), (b, _)| a.cmp(b));
    Ok(found)
}

/// Refuses a name that is not that of an FMU.
pub fn check_ending(path: &Path) -> Result<()> {
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("fmu")) {
        return Ok(());
    }
    Err(Error::new(Code::Usage, "the output file is not an .fmu")
        .at(path)
        .help("use a name that ends in .fmu"))
}

/// Writes the archive.
pub fn write(path: &Path, entries: &[Entry]) -> Result<()> {
    let entries = entries.iter().map(|(name, content)| match &content.what {
        What::Bytes(bytes) => (name.as_str(), archive::Content::Bytes(bytes)),
        What::File(file) => (name.as_str(), archive::Content::File(file)),
    });
    archive::write(path, entries)
        .map_err(|e| Error::new(Code::Output, "the FMU cannot be written").at(path).why(e))
}
