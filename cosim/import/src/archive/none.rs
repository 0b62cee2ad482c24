//! Instead of `read` and `write`, in libraries that contain no code for archives.

use std::io::{self, Read, Seek};
use std::path::Path;

use super::{Content, Room, Unpacked};
use cosim_base::error::{Code, Error, Result};

pub(super) fn unpack(
    _: impl Read + Seek,
    archive: &Path,
    _: impl Fn(&Path) -> bool,
    _: &mut Room,
) -> Result<Unpacked> {
    Err(Error::new(Code::Archive, "this library reads no archives").at(archive))
}

pub(super) fn write<'a>(
    _: &Path,
    _: impl IntoIterator<Item = (&'a str, Content<'a>)>,
) -> io::Result<()> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "this library writes no archives"))
}
