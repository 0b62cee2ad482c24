//! The dynamic information of an ELF file, which the generic reader does not provide.

use super::Side;
use anyhow::Result;
use object::{
    LittleEndian,
    elf::{self, SHT_DYNSYM},
    read::elf::{Dyn, FileHeader, Rel, Rela, SectionHeader, Sym},
};
use std::collections::BTreeSet;

/// Libraries that are parts of glibc.
const GLIBC_PARTS: [&str; 9] = [
    "libc.so.6",
    "libm.so.6",
    "libdl.so.2",
    "libpthread.so.0",
    "librt.so.1",
    "libutil.so.1",
    "ld-linux.so.2",
    "ld-linux-x86-64.so.2",
    "ld-linux-aarch64.so.1",
];

/// Reads a file of either word size.
pub(super) fn read<Header: FileHeader<Endian = LittleEndian>>(bytes: &[u8]) -> Result<Side> {
    let header = Header::parse(bytes)?;
    let endian = header.endian()?;
    let sections = header.sections(endian, bytes)?;
    let symbols = sections.symbols(endian, bytes, SHT_DYNSYM)?;
    let text = |name: &[u8]| String::from_utf8_lossy(name).into_owned();

    let mut hidden_exports = BTreeSet::new();
    for symbol in symbols.iter() {
        if symbol.st_name(endian) != 0 && !symbol.is_undefined(endian) && !symbol.is_local() {
            hidden_exports.insert(text(symbol.name(endian, symbols.strings())?));
        }
    }
    let mut interposable = BTreeSet::new();
    for section in sections.iter() {
        let mut indices = Vec::new();
        if let Some((relocations, _)) = section.rela(endian, bytes)? {
            indices.extend(relocations.iter().filter_map(|r| r.symbol(endian, false)));
        }
        if let Some((relocations, _)) = section.rel(endian, bytes)? {
            indices.extend(relocations.iter().filter_map(|r| r.symbol(endian)));
        }
        for index in indices {
            let symbol = symbols.symbol(index)?;
            if !symbol.is_undefined(endian) && !symbol.is_local() {
                interposable.insert(text(symbol.name(endian, symbols.strings())?));
            }
        }
    }
    let mut needed = BTreeSet::new();
    if let Some((entries, strings)) = sections.dynamic(endian, bytes)? {
        let strings = sections.strings(endian, bytes, strings)?;
        for entry in entries.iter().filter(|entry| entry.tag(endian) == elf::DT_NEEDED) {
            needed.insert(text(entry.string(endian, strings)?));
        }
    }
    let mut versions = BTreeSet::new();
    if let Some((mut files, strings)) = sections.gnu_verneed(endian, bytes)? {
        let strings = sections.strings(endian, bytes, strings)?;
        while let Some((_, mut entries)) = files.next()? {
            while let Some(entry) = entries.next()? {
                versions.insert(text(entry.name(endian, strings)?));
            }
        }
    }
    let is_system = |name: &str| GLIBC_PARTS.contains(&name);
    let debugging = BTreeSet::new();
    Ok(Side { hidden_exports, interposable, needed, versions, debugging, is_system })
}
