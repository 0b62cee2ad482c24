//! An FMU without its binaries: description and documents.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::write::binaries;
use cosim_base::error::{Code, Error, Result};
use cosim_import::temporary::Unpacked;
use cosim_import::{Fmu, archive as packed};
use cosim_pack::archive;

/// The platforms for which an FMU has a library, and its archive with only description and
/// documents.
pub(crate) fn of(file: &Path) -> Result<(Vec<String>, Vec<u8>)> {
    let platforms = binaries(&*Fmu::open(file)?)?;
    let public = packed::unpack_part(file, is_public)?;
    let folder = Unpacked::new()?;
    let shell = folder.path().join("shell.fmu");
    archive::write(&shell, &archive::files(public.path())?)?;
    let bytes = fs::read(&shell).map_err(|why| unkept(&shell).why(why))?;
    Ok((platforms.into_iter().map(str::to_owned).collect(), bytes))
}

/// The FMU of a received shell, valid as long as the folder exists.
pub(super) fn open(shell: &[u8], name: &str) -> Result<(Arc<Fmu>, Unpacked)> {
    let folder = Unpacked::new()?;
    let file: PathBuf = folder.path().join(Path::new(name).file_name().unwrap_or("it".as_ref()));
    fs::write(&file, shell).map_err(|why| unkept(&file).why(why))?;
    Ok((Fmu::open(&file)?, folder))
}

fn unkept(file: &Path) -> Error {
    Error::new(Code::File, "a temporary file cannot be written or read").at(file)
}

/// Whether a file of the FMU is documentation.
pub(super) fn is_for_people(path: &Path) -> bool {
    path.starts_with("documentation") || path == Path::new("model.png")
}

fn is_public(path: &Path) -> bool {
    is_for_people(path) || path == Path::new("modelDescription.xml")
}
