//! Unpacking .fmu and .ssp archives (ZIP) from strangers.
//!
//! Every entry is looked at before the first byte is written: a name that leaves the folder, an
//! absolute name, a backslash, a link, too many entries or an absurd compression ratio refuse
//! the archive and name the entry. The folder is private (0700) and vanishes with its value.

use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::{Component, Path, PathBuf};

use tempfile::TempDir;
use zip::ZipArchive;

use crate::error::{Code, Error, Result};

const MAX_ENTRIES: usize = 10_000;
const MAX_BYTES: u64 = 4 << 30;
/// Ratio refused for entries above `RATIO_FROM` bytes; deflate cannot reach it on real content.
const MAX_RATIO: u64 = 500;
const RATIO_FROM: u64 = 10 << 20;

/// Unpacks `archive` into a fresh folder.
pub fn unpack(archive: &Path) -> Result<TempDir> {
    let file = File::open(archive)
        .map_err(|e| Error::new(Code::File, "the archive cannot be opened").at(archive).why(e))?;
    let mut zip = ZipArchive::new(BufReader::new(file)).map_err(|e| broken(archive, e))?;
    check(&mut zip, archive)?;
    let folder = tempfile::Builder::new()
        .prefix("cosim-")
        .permissions(fs::Permissions::from_mode(0o700))
        .tempdir()
        .map_err(|e| Error::new(Code::File, "no temporary folder can be made").why(e))?;
    for index in 0..zip.len() {
        extract(&mut zip, index, folder.path(), archive)?;
    }
    Ok(folder)
}

fn check(zip: &mut ZipArchive<BufReader<File>>, archive: &Path) -> Result<()> {
    if zip.len() > MAX_ENTRIES {
        return Err(refused(archive, format!("an archive of {} entries", zip.len()))
            .why(format!("more than {MAX_ENTRIES} are refused")));
    }
    let mut total = 0_u64;
    for index in 0..zip.len() {
        let entry = zip.by_index_raw(index).map_err(|e| broken(archive, e))?;
        let name = entry.name().map_err(|e| broken(archive, e))?.into_owned();
        let refuse = |why: &str| Err(refused(archive, format!("the entry '{name}'")).why(why));
        if entry.is_symlink() {
            return refuse("it is a symbolic link");
        }
        if name.contains('\\') {
            return refuse("its name has a backslash; ZIP separates by '/'");
        }
        if !stays_inside(Path::new(&name)) {
            return refuse("it would be written outside of the unpacked folder");
        }
        let (size, packed) = (entry.size(), entry.compressed_size());
        total = total.saturating_add(size);
        if size > RATIO_FROM && size / packed.max(1) > MAX_RATIO {
            return refuse("its compression ratio is absurd");
        }
        if total > MAX_BYTES {
            return refuse("with it the archive unpacks to more than 4 GiB");
        }
    }
    Ok(())
}

fn stays_inside(name: &Path) -> bool {
    name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
        && name.components().next().is_some()
}

fn extract(
    zip: &mut ZipArchive<BufReader<File>>,
    index: usize,
    folder: &Path,
    archive: &Path,
) -> Result<()> {
    let mut entry = zip.by_index(index).map_err(|e| broken(archive, e))?;
    let name = entry.name().map_err(|e| broken(archive, e))?.into_owned();
    let failed = |e: std::io::Error| {
        Error::new(Code::Archive, format!("the entry '{name}' cannot be unpacked"))
            .at(archive)
            .why(e)
    };
    let path: PathBuf = folder.join(&name);
    if entry.is_dir() {
        return fs::create_dir_all(&path).map_err(failed);
    }
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).map_err(failed)?;
    }
    let mut file = File::create_new(&path).map_err(failed)?;
    // The sizes in the directory may lie: never write more than was checked.
    let claimed = entry.size();
    let written = std::io::copy(&mut entry.by_ref().take(claimed), &mut file).map_err(failed)?;
    if written != claimed {
        return Err(broken(archive, format!("the entry '{name}' is cut short")));
    }
    Ok(())
}

fn broken(archive: &Path, why: impl std::fmt::Display) -> Error {
    Error::new(Code::Archive, "the archive is damaged or no ZIP file")
        .at(archive)
        .why(why)
        .help("pack or download it again")
}

fn refused(archive: &Path, what: String) -> Error {
    Error::new(Code::Archive, format!("{what} is refused")).at(archive)
}
