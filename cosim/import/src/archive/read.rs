//! Reads archives.

use std::collections::HashSet;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Read, Seek, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use zip::ZipReadOptions;
use zip::unstable::read::ZipIterable;

use super::check::{self, Checked};
use super::{PIECE, Room, Unpacked};
use cosim_base::error::{Code, Error, Result};

impl Room {
    /// Takes the room for the files that are written, and for the folders of all.
    fn take(&mut self, checked: &[Checked], wanted: impl Fn(&Path) -> bool) -> bool {
        let mut places = HashSet::new();
        for entry in checked {
            let written = entry.is_folder || wanted(&entry.path);
            places.extend(entry.path.ancestors().skip(usize::from(!written)));
            self.bytes = match self.bytes.checked_sub(if written { entry.size } else { 0 }) {
                Some(left) => left,
                None => return false,
            };
        }
        let left = self.places.checked_sub(places.len());
        self.places = left.unwrap_or(0);
        left.is_some()
    }
}

/// Unpacks the wanted files of the archive in `reader`; `archive` is its name in messages.
pub(super) fn unpack(
    reader: impl Read + Seek,
    archive: &Path,
    wanted: impl Fn(&Path) -> bool,
    room: &mut Room,
) -> Result<Unpacked> {
    let mut zip =
        ZipIterable::try_new(reader, Default::default()).map_err(|e| broken(archive, e))?;
    let checked = check::entries(&mut zip, archive)?;
    if !room.take(&checked, &wanted) {
        let why = "with it, the archives of the system unpack to more than 16 GiB, or to more than \
                   100000 files and folders";
        return Err(Error::new(Code::Archive, "the archive is refused").at(archive).why(why));
    }
    let folder = Unpacked::new()?;
    let entries = zip.files().map_err(|e| broken(archive, e))?;
    for checked in &checked {
        let Some(entry) = entries.next() else { break };
        let entry = entry.map_err(|e| broken(archive, e))?;
        let path = folder.path().join(&checked.path);
        let unwanted = !wanted(&checked.path);
        let made = match checked.is_folder {
            true => Some(&*path).filter(|_| !unwanted),
            false => path.parent(),
        };
        made.map_or(Ok(()), fs::create_dir_all).map_err(|e| not_unpacked(archive, checked, &e))?;
        if checked.is_folder || unwanted {
            continue;
        }
        let file = create(&path, checked).map_err(|e| not_unpacked(archive, checked, &e))?;
        let content = entry
            .with_reader(entries.reader_mut(), ZipReadOptions::new())
            .map_err(|e| broken(archive, e))?;
        copy(content, file, checked, archive)?;
    }
    Ok(folder)
}

fn create(path: &Path, checked: &Checked) -> std::io::Result<File> {
    let mode = if checked.executable { 0o700 } else { 0o600 };
    OpenOptions::new().write(true).create_new(true).mode(mode).open(path)
}

/// The sizes in the directory may be wrong: one byte more than was checked refuses the archive. The
/// end of the content is reached, so its checksum is verified.
fn copy(content: impl Read, file: File, checked: &Checked, archive: &Path) -> Result<()> {
    let mut limited = content.take(checked.size.saturating_add(1));
    let mut file = BufWriter::with_capacity(PIECE, file);
    let copied = std::io::copy(&mut limited, &mut file);
    let written = copied
        .and_then(|written| file.flush().map(|()| written))
        .map_err(|e| not_unpacked(archive, checked, &e))?;
    if written == checked.size {
        return Ok(());
    }
    let claimed = checked.size;
    Err(refused(archive, &checked.name)
        .why(format!("its content does not have the {claimed} bytes declared in the directory")))
}

fn not_unpacked(archive: &Path, checked: &Checked, error: &std::io::Error) -> Error {
    Error::new(Code::Archive, format!("the entry '{}' cannot be unpacked", checked.name))
        .at(archive)
        .why(error)
        .help("repack or download it again")
}

pub(super) fn broken(archive: &Path, why: impl std::fmt::Display) -> Error {
    Error::new(Code::Archive, "the archive is damaged or not a ZIP file")
        .at(archive)
        .why(why)
        .help("repack or download it again")
}

pub(super) fn refused(archive: &Path, name: &str) -> Error {
    Error::new(Code::Archive, format!("the entry '{}' is refused", name.escape_debug())).at(archive)
}
