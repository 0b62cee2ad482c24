//! The dynamic information of a PE file, which the generic reader does not provide.
//!
//! Calls within a DLL never go through a table, so no other library's functions can be called.

use super::Side;
use anyhow::Result;
use object::{
    LittleEndian, pe,
    read::pe::{ImageNtHeaders, PeFile},
};
use std::collections::BTreeSet;

/// Libraries that every Windows since 8 has, as far as Rust's standard library uses them. Sockets
/// and the home folder (the last two) are included if the standard library is linked as one piece.
/// The `api-ms-win-` ones are names of parts of them.
const SYSTEM: [&str; 9] = [
    "kernel32.dll",
    "kernelbase.dll",
    "ntdll.dll",
    "msvcrt.dll",
    "ucrtbase.dll",
    "bcryptprimitives.dll",
    "advapi32.dll",
    "userenv.dll",
    "ws2_32.dll",
];

/// Reads a file of either word size.
pub(super) fn read<Headers: ImageNtHeaders>(file: &PeFile<'_, Headers>) -> Result<Side> {
    let text = |name: &[u8]| String::from_utf8_lossy(name).into_owned();
    let mut needed = BTreeSet::new();
    if let Some(imports) = file.import_table()? {
        let mut descriptors = imports.descriptors()?;
        while let Some(descriptor) = descriptors.next()? {
            needed.insert(text(imports.name(descriptor.name.get(LittleEndian))?));
        }
    }
    if let Some(imports) = file.delay_load_import_table()? {
        let mut descriptors = imports.descriptors()?;
        while let Some(descriptor) = descriptors.next()? {
            needed.insert(text(imports.name(descriptor.dll_name_rva.get(LittleEndian))?));
        }
    }
    let mut debugging = BTreeSet::new();
    let symbols = file.nt_headers().file_header().number_of_symbols.get(LittleEndian);
    if symbols > 0 {
        debugging.insert(format!("a table of {symbols} symbols"));
    }
    let directory = file.data_directory(pe::IMAGE_DIRECTORY_ENTRY_DEBUG);
    if directory.is_some_and(|directory| directory.size.get(LittleEndian) > 0) {
        debugging.insert("a debug directory".to_owned());
    }
    let is_system = |name: &str| {
        let name = name.to_ascii_lowercase();
        SYSTEM.contains(&name.as_str()) || name.starts_with("api-ms-win-")
    };
    let (hidden_exports, interposable, versions) = Default::default();
    Ok(Side { hidden_exports, interposable, needed, versions, debugging, is_system })
}
