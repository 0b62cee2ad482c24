//! Reads files of system descriptions into raw structures: SSP (`ssp`) and OSP (`osp`).
//!
//! A reader collects problems and continues, so that all are reported at once. Unknown content is
//! an error; known but unsupported content is refused by name.

mod gathered;
mod osp;
mod source;
mod ssp;

use std::path::{Path, PathBuf};

use super::opened::OpenedFmus;
use super::raw::RawSystem;
use cosim_base::error::{Code, Error, Result};
use cosim_base::xml::{self, Element};
use gathered::Gathered;
use source::Base;

pub(super) use osp::{LOG_FILE, NAMESPACE as OSP_NAMESPACE};
pub(super) use source::write as write_source;
pub(super) use ssp::SSD_FILE;

/// The file of an OSP system in its folder.
pub(super) const OSP_FILE: &str = "OspSystemStructure.xml";

/// Whether a path is a system description rather than an FMU: by its extension, or a folder.
pub(super) fn is_system(path: &Path) -> bool {
    let ends_with = |end| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(end));
    path.is_dir() || ["ssd", "ssp", "xml"].into_iter().any(ends_with)
}

/// Reads a .ssd, .ssp or OspSystemStructure.xml file, or the folder of the latter. Its FMUs are
/// files, or `unpacked` folders.
pub(super) fn read(path: &Path, unpacked: bool) -> Result<RawSystem> {
    let ends_with = |end| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(end));
    if ends_with("ssp") {
        return package(path);
    }
    let file: PathBuf = if path.is_dir() { in_folder(path)? } else { path.to_owned() };
    let root = xml::read(&file, &file)?;
    let mut gathered = Gathered::default();
    gathered.fmus = OpenedFmus::new(unpacked);
    any(&root, &file, Base::of_file(&file), gathered)
}

/// Reads a system description from text instead of a file; it cannot refer to other files.
pub(super) fn read_text(text: &str) -> Result<RawSystem> {
    let file = Path::new("text");
    let base = Base { folder: None, archive: None };
    any(&xml::parse(text, file)?, file, base, Gathered::default())
}

fn in_folder(folder: &Path) -> Result<PathBuf> {
    let names = [OSP_FILE, ssp::SSD_FILE];
    let found = names.iter().map(|name| folder.join(name)).find(|file| file.is_file());
    found.ok_or_else(|| {
        Error::new(Code::File, "the folder has no system description")
            .at(folder)
            .why(format!("there is neither {} in it", names.join(" nor ")))
    })
}

fn any(root: &Element, file: &Path, base: Base, gathered: Gathered) -> Result<RawSystem> {
    match root.name.as_str() {
        "OspSystemStructure" => osp::read(root, file, base, gathered),
        "SystemStructureDescription" => ssp::read(root, file, base, gathered),
        other => Err(Error::new(Code::Ssd, format!("the root element is <{other}>"))
            .at_line(file, root.line)
            .why(
                "a system description is a SystemStructureDescription (SSP) or an \
                 OspSystemStructure (OSP)",
            )),
    }
}

fn package(file: &Path) -> Result<RawSystem> {
    let mut gathered = Gathered::default();
    let (description, shown, base) = unpack(file, &mut gathered)?;
    let root = xml::read(&description, &shown)?;
    ssp::read(&root, &shown, base, gathered)
}

/// The description in an .ssp, its name in messages, and the base of its sources.
fn unpack(file: &Path, gathered: &mut Gathered) -> Result<(PathBuf, PathBuf, Base)> {
    let folder = match gathered.packages.get(file) {
        Some(unpacked) => unpacked.path().to_owned(),
        None => {
            let unpacked = gathered.fmus.unpack(file)?;
            let folder = unpacked.path().to_owned();
            gathered.packages.insert(file.to_owned(), unpacked);
            folder
        }
    };
    let description = folder.join(ssp::SSD_FILE);
    let shown = file.join(ssp::SSD_FILE);
    if !description.is_file() {
        return Err(Error::new(Code::Archive, format!("the package has no {}", ssp::SSD_FILE))
            .at(file)
            .help("an .ssp has that file at its top level, not in a folder"));
    }
    Ok((description, shown, Base::of_archive(&folder)))
}
