//! The dynamic information of a Mach-O file, which the generic reader does not provide.
//!
//! Names are bound together with the library that has them (two-level namespace), so no other
//! library's can take precedence.

use super::Side;
use anyhow::Result;
use object::{
    Endianness,
    read::macho::{MachHeader, MachOFile},
};
use std::collections::BTreeSet;

/// Folder of the libraries that every macOS has.
const SYSTEM: [&str; 2] = ["/usr/lib/", "/System/Library/"];

/// Names that linkers give to parts of the file itself.
pub(super) const OF_LINKER: [&str; 2] = ["__dso_handle", "_mh_dylib_header"];

/// Reads a file with code for one machine.
pub(super) fn read<Header: MachHeader<Endian = Endianness>>(
    file: &MachOFile<'_, Header>,
    bytes: &[u8],
) -> Result<Side> {
    let endian = file.endian();
    let mut needed = BTreeSet::new();
    let mut commands = file.macho_header().load_commands(endian, bytes, 0)?;
    while let Some(command) = commands.next()? {
        if let Some(library) = command.dylib()? {
            let name = command.string(endian, library.dylib.name)?;
            needed.insert(String::from_utf8_lossy(name).into_owned());
        }
    }
    let is_system = |name: &str| SYSTEM.iter().any(|folder| name.starts_with(folder));
    let (hidden_exports, interposable, versions, debugging) = Default::default();
    Ok(Side { hidden_exports, interposable, needed, versions, debugging, is_system })
}
