//! Unpacks .fmu and .ssp archives (ZIP) from untrusted sources, and writes archives.
//!
//! Every entry is checked before the first byte is written (`archive::check`); an archive that
//! breaks a rule is refused, and the entry is named. Then no more is written than the entries
//! declared.
//!
//! Libraries inside exported FMUs are built without the feature `archives`: their FMUs are unpacked.

#[cfg(feature = "archives")]
mod check;
#[cfg(not(feature = "archives"))]
mod none;
#[cfg(feature = "archives")]
mod read;
#[cfg(feature = "archives")]
mod write;

use std::io::{BufReader, Read, Seek};
use std::path::Path;

pub use super::temporary::Unpacked;
use cosim_base::error::{Code, Error, Result};
use cosim_base::files;
#[cfg(not(feature = "archives"))]
use none as read;
#[cfg(not(feature = "archives"))]
use none as write;

/// Bytes read and written at once.
const PIECE: usize = 1 << 16;

/// What all archives of one system may unpack together: each alone stays within its own limits, but
/// archives can contain archives.
#[cfg_attr(not(feature = "archives"), expect(dead_code, reason = "nothing is unpacked"))]
pub struct Room {
    bytes: u64,
    places: usize,
}

impl Default for Room {
    fn default() -> Self {
        Self { bytes: 16 << 30, places: 100_000 }
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
    read::unpack(BufReader::with_capacity(PIECE, file), archive, wanted, room)
}

/// Unpacks the archive in `reader`; `archive` is its name in messages.
pub fn unpack_from(reader: impl Read + Seek, archive: &Path) -> Result<Unpacked> {
    read::unpack(reader, archive, |_| true, &mut Room::default())
}

/// The content of an entry.
#[derive(Clone, Copy)]
pub enum Content<'a> {
    /// From memory.
    Bytes(&'a [u8]),
    /// From a file; if that is executable, so is the entry.
    File(&'a Path),
    /// From a file that is compressed already, such as an FMU.
    Compressed(&'a Path),
}

/// Writes an archive of entries, each with its path (with `/` as separator): with fixed times and
/// permissions, so that the same content gives the same bytes, and under the final name only when
/// it is complete.
pub fn write<'a>(
    path: &Path,
    entries: impl IntoIterator<Item = (&'a str, Content<'a>)>,
) -> std::io::Result<()> {
    write::write(path, entries)
}

#[cfg(all(test, feature = "archives"))]
mod tests {
    use super::*;
    use std::io::Write;

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
