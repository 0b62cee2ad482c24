//! Checks the header of a shared library before the dynamic linker sees the file.
//!
//! ELF (System V ABI, chapter 4): magic, class, byte order, type ET_DYN, machine. A library for
//! another machine is reported as such, whatever folder it is in.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// EM_* numbers and their names in FMI's platform tuples.
const MACHINES: &[(u16, &str)] =
    &[(3, "x86"), (40, "arm"), (62, "x86_64"), (183, "aarch64"), (243, "riscv")];
const SHARED_OBJECT: u16 = 3;

/// The machines whose Linux binaries are supported.
const SUPPORTED: [&str; 2] = ["x86_64", "aarch64"];

/// Why the file at `path` is not a library for this machine; `Ok` if it may be one.
pub(super) fn check(path: &Path) -> Result<(), String> {
    let mut header = [0; 20];
    File::open(path)
        .and_then(|mut file| file.read_exact(&mut header))
        .map_err(|e| format!("its header cannot be read: {e}"))?;
    judge(&header, std::env::consts::ARCH)
}

/// The binaries folder for a library with these bytes.
pub fn platform(bytes: &[u8]) -> Result<&'static str, String> {
    let header = bytes.first_chunk().ok_or("it has no header")?;
    let machine = machine(header)?;
    of_machine(machine)
        .first()
        .copied()
        .ok_or_else(|| format!("FMUs for {machine} are not supported"))
}

/// Whether binaries in that folder are for this machine.
pub fn is_here(folder: &str) -> bool {
    cfg!(target_os = "linux") && of_machine(std::env::consts::ARCH).contains(&folder)
}

/// The folder of this machine's binaries.
pub fn here() -> Option<&'static str> {
    let own = of_machine(std::env::consts::ARCH).first().copied();
    own.filter(|_| cfg!(target_os = "linux"))
}

/// The folder names of each platform.
pub fn all_folders() -> impl Iterator<Item = &'static [&'static str]> {
    SUPPORTED.into_iter().map(of_machine)
}

/// All folder names of a platform.
pub fn folders(folder: &str) -> &'static [&'static str] {
    all_folders().find(|names| names.contains(&folder)).unwrap_or_default()
}

/// The folders of a machine's Linux binaries.
pub(super) fn of_machine(machine: &str) -> &'static [&'static str] {
    if SUPPORTED.contains(&machine) { fmu_standard::folders("linux", machine) } else { &[] }
}

fn judge(header: &[u8; 20], wanted: &str) -> Result<(), String> {
    match machine(header)? {
        found if found == wanted => Ok(()),
        found => Err(format!("it is built for {found}, this machine is {wanted}")),
    }
}

/// The machine for which a shared object is built.
fn machine(header: &[u8; 20]) -> Result<&'static str, String> {
    if header[..4] != *b"\x7fELF" {
        return Err("it is not an ELF file".to_owned());
    }
    if header[4] != 2 || header[5] != 1 {
        return Err("it is not 64-bit little-endian".to_owned());
    }
    let word = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
    if word(16) != SHARED_OBJECT {
        return Err("it is not a shared object".to_owned());
    }
    let found = MACHINES.iter().find(|(number, _)| *number == word(18));
    match found {
        Some((_, name)) => Ok(name),
        None => Err(format!("it is built for the machine number {} of ELF", word(18))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(change: impl Fn(&mut [u8; 20])) -> [u8; 20] {
        let mut header = [0; 20];
        header[..6].copy_from_slice(b"\x7fELF\x02\x01");
        (header[16], header[18]) = (3, 62);
        change(&mut header);
        header
    }

    #[test]
    fn only_a_shared_object_of_this_machine() {
        assert_eq!(judge(&header(|_| ()), "x86_64"), Ok(()));
        for (change, part) in [
            (&(|h: &mut [u8; 20]| h[0] = b'M') as &dyn Fn(&mut [u8; 20]), "not an ELF"),
            (&|h| h[4] = 1, "64-bit"),
            (&|h| h[16] = 2, "not a shared object"),
            (&|h| h[18] = 183, "built for aarch64, this machine is x86_64"),
            (&|h| h[18] = 8, "number 8"),
        ] {
            let why = judge(&header(change), "x86_64").unwrap_err();
            assert!(why.contains(part), "{why}");
        }
    }
}
