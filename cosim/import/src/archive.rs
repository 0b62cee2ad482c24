//! Unpacks .fmu and .ssp archives (ZIP) from untrusted sources.
//!
//! Every entry is checked before the first byte is written (`archive::check`); an archive that
//! breaks a rule is refused, and the entry is named. Then no more is written than the entries
//! declared.

use std::collections::HashSet;
use std::fs::{self, File, OpenOptions};
use std::io::{BufReader, BufWriter, Read, Seek, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use zip::ZipReadOptions;
use zip::unstable::read::ZipIterable;

pub use super::temporary::Unpacked;
use check::Checked;
use cosim_base::error::{Code, Error, Result};
use cosim_base::files;

mod check;

/// Bytes read and written at once.
const PIECE: usize = 1 << 16;

/// What all archives of one system may unpack together: each alone stays within its own limits, but
/// archives can contain archives.
pub struct Room {
    bytes: u64,
    places: usize,
}

impl Default for Room {
    fn default() -> Self {
        Self { bytes: 16 << 30, places: 100_000 }
    }
}

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

/// Unpacks `archive` into a new folder.
pub fn unpack(archive: &Path) -> Result<Unpacked> {
    unpack_part(archive, |_| true)
}

/// The same with only the wanted files; the others only leave their folders. All are checked.
pub fn unpack_part(archive: &Path, wanted: impl Fn(&Path) -> bool) -> Result<Unpacked> {
    unpack_within(archive, wanted, &mut Room::default())
}

/// The same, if there is room for it beside other archives.
pub fn unpack_within(
    archive: &Path,
    wanted: impl Fn(&Path) -> bool,
    room: &mut Room,
) -> Result<Unpacked> {
    let file = files::open_input(archive)
        .map_err(|e| Error::new(Code::File, "the archive cannot be opened").at(archive).why(e))?;
    part_from(BufReader::with_capacity(PIECE, file), archive, wanted, room)
}

/// Unpacks the archive in `reader`; `archive` is its name in messages.
pub fn unpack_from(reader: impl Read + Seek, archive: &Path) -> Result<Unpacked> {
    part_from(reader, archive, |_| true, &mut Room::default())
}

fn part_from(
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

fn broken(archive: &Path, why: impl std::fmt::Display) -> Error {
    Error::new(Code::Archive, "the archive is damaged or not a ZIP file")
        .at(archive)
        .why(why)
        .help("repack or download it again")
}

fn refused(archive: &Path, name: &str) -> Error {
    Error::new(Code::Archive, format!("the entry '{}' is refused", name.escape_debug())).at(archive)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An archive with files of 5 bytes.
    fn archive(names: &[&str]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut zip = zip::ZipWriter::new(file.reopen().unwrap());
        for name in names {
            zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
            zip.write_all(b"bytes").unwrap();
        }
        zip.finish().unwrap();
        file
    }

    #[test]
    fn archives_share_the_room_for_all() {
        let file = archive(&["a/b/x", "a/y", "doc/z"]);
        let unpack = |room: &mut Room| {
            unpack_within(file.path(), |path| path.starts_with("a"), room).map(drop)
        };
        // The folder itself, a, a/b, doc and two files; z is not written.
        let mut room = Room { bytes: 25, places: 20 };
        unpack(&mut room).unwrap();
        assert_eq!((room.bytes, room.places), (15, 14));
        unpack(&mut room).unwrap();
        for mut room in [room, Room { bytes: 99, places: 5 }] {
            let error = unpack(&mut room).unwrap_err();
            assert_eq!(error.code(), Code::Archive);
            let text = error.to_string();
            assert!(text.contains("16 GiB, or to more than 100000 files and folders"), "{text}");
        }
    }
}
