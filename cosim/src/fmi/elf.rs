//! The header of a shared library, looked at before the dynamic linker sees the file.
//!
//! ELF (System V ABI, chapter 4): magic, class, byte order, type ET_DYN, machine. A library of
//! another machine is then told as such, whatever folder it lies in.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// EM_* numbers and their names in FMI's platform tuples.
const MACHINES: &[(u16, &str)] =
    &[(3, "x86"), (40, "arm"), (62, "x86_64"), (183, "aarch64"), (243, "riscv")];
const SHARED_OBJECT: u16 = 3;

/// Why the file at `path` is no library for this machine; `Ok` if it may be one.
pub(super) fn check(path: &Path) -> Result<(), String> {
    let mut header = [0; 20];
    File::open(path)
        .and_then(|mut file| file.read_exact(&mut header))
        .map_err(|e| format!("its header cannot be read: {e}"))?;
    judge(&header, std::env::consts::ARCH)
}

fn judge(header: &[u8; 20], machine: &str) -> Result<(), String> {
    if header[..4] != *b"\x7fELF" {
        return Err("it is no ELF file".to_owned());
    }
    if header[4] != 2 || header[5] != 1 {
        return Err("it is not of 64 bits and little-endian".to_owned());
    }
    let word = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
    if word(16) != SHARED_OBJECT {
        return Err("it is no shared object".to_owned());
    }
    let found = MACHINES.iter().find(|(number, _)| *number == word(18));
    match found {
        Some((_, name)) if *name == machine => Ok(()),
        Some((_, name)) => Err(format!("it is built for {name}, this machine is {machine}")),
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
            (&(|h: &mut [u8; 20]| h[0] = b'M') as &dyn Fn(&mut [u8; 20]), "no ELF"),
            (&|h| h[4] = 1, "64 bits"),
            (&|h| h[16] = 2, "no shared object"),
            (&|h| h[18] = 183, "built for aarch64, this machine is x86_64"),
            (&|h| h[18] = 8, "number 8"),
        ] {
            let why = judge(&header(change), "x86_64").unwrap_err();
            assert!(why.contains(part), "{why}");
        }
    }
}
