//! Writes systems to files: SSP 1.0 (.ssd, .ssp) and OSP (`OspSystemStructure.xml`, or its folder).
//!
//! The output is the checked system, flat and plain, so that other tools can read it: every
//! connected connector is listed with its type and no other, start values are inline, and unit
//! conversions are written as the equivalent transformation (libcosim and FMPy do not convert
//! units). Whatever a format cannot express is refused by name or reported as a note.

mod files;
mod osp;
mod ssd;
mod transformation;
mod units;

use std::fs;
use std::path::{Path, PathBuf};

use super::{Model, System};
use cosim_base::error::{Code, Error, Result};
use cosim_base::files::replace;
use files::Files;
pub use ssd::base_step;

use super::read::{OSP_FILE, SSD_FILE};

/// How to write a system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Ssd,
    Ssp,
    /// The file alone.
    OspFile,
    /// The file with its FMUs.
    OspFolder,
}

impl Format {
    fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("ssd") => Ok(Format::Ssd),
            Some("ssp") => Ok(Format::Ssp),
            Some("xml") => Ok(Format::OspFile),
            None => Ok(Format::OspFolder),
            Some(_) if path.is_dir() => Ok(Format::OspFolder),
            Some(other) => {
                Err(Error::new(Code::Usage, format!("no format has the extension .{other}"))
                    .at(path)
                    .help("write .ssd, .ssp, .xml (OSP) or the name of a folder (OSP)"))
            }
        }
    }
}

impl System {
    /// Writes the system to a .ssd or .ssp file, an OSP .xml file, or an OSP folder with its FMUs;
    /// returns notes.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Vec<String>> {
        let path = path.as_ref();
        self.ready()?;
        let mut notes = Vec::new();
        match Format::of(path)? {
            Format::Ssd => {
                let folder = parent(path);
                let files = Files::beside(self, &folder)?;
                store(path, ssd::text(self, &files)?.as_bytes())?;
                files.copy(&folder)?;
            }
            Format::Ssp => {
                let files = Files::packed(self, "resources/");
                files.pack(path, ssd::text(self, &files)?.as_bytes())?;
            }
            Format::OspFile => {
                let folder = parent(path);
                let files = Files::beside(self, &folder)?;
                self.write_osp(path, &files, &mut notes)?;
            }
            Format::OspFolder => {
                fs::create_dir_all(path).map_err(|e| unwritten(path, e))?;
                let files = Files::packed(self, "");
                self.write_osp(&path.join(OSP_FILE), &files, &mut notes)?;
            }
        }
        Ok(notes)
    }

    fn write_osp(&self, file: &Path, files: &Files, notes: &mut Vec<String>) -> Result<()> {
        let text = osp::text(self, files, notes)?;
        store(file, text.as_bytes())?;
        let log = file.with_file_name(osp::LOG_FILE);
        match osp::log_config(self, notes) {
            Some(text) => store(&log, text.as_bytes())?,
            None if log.is_file() => notes.push(format!(
                "{} selects the variables that libcosim records: it is that of another system",
                log.display()
            )),
            None => (),
        }
        files.copy(&parent(file))
    }

    /// The system as part of a package: its description, and the FMUs under their names in `folder`
    /// beside it.
    pub fn packed(&self, folder: &str) -> Result<Packed> {
        let files = Files::packed(self, folder);
        let sums = self.components.iter().any(|c| matches!(c.model, Model::Function(_)));
        // SSP cannot express sums.
        let (name, text) = match sums {
            true => (OSP_FILE, osp::text(self, &files, &mut Vec::new())?),
            false => (SSD_FILE, ssd::text(self, &files)?),
        };
        Ok(Packed { name, text, fmus: files.into_copies() })
    }

    /// The folders of the archives that contained the system.
    fn archives(&self) -> impl Iterator<Item = &Path> {
        self.raw.iter().flat_map(|raw| raw._unpacked.iter().map(|folder| folder.path()))
    }

    /// Components that are FMUs, with their files.
    fn fmus(&self) -> impl Iterator<Item = (usize, &Path)> {
        let components = self.components.iter().enumerate();
        components.filter_map(|(position, c)| Some((position, c.file.as_deref()?)))
    }
}

/// A system in a package.
pub struct Packed {
    /// Name of the description file.
    pub name: &'static str,
    /// Its text.
    pub text: String,
    /// Names relative to the description, and the original files.
    pub fmus: Vec<(String, PathBuf)>,
}

fn parent(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn store(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, bytes).map_err(|e| unwritten(path, e))
}

fn unwritten(path: &Path, error: impl std::fmt::Display) -> Error {
    Error::new(Code::Output, "the system cannot be written").at(path).why(error)
}

/// What the format cannot express.
fn unsaid(format: &str, what: String) -> Error {
    Error::new(Code::Format, format!("{format} cannot express that {what}"))
}
