//! What a shared library asks of the machine and shows to it, read from its ELF file.
//!
//! A shipped library exports the 44 functions of FMI 2.0 and nothing else, resolves all calls to
//! them within itself (so that two FMUs in a process never meet), and needs nothing but glibc.

use super::{compile::GLIBC, platform::Platform};
use anyhow::{Result, bail, ensure};
use fmu_kit::kernel::Call;
use object::{
    LittleEndian,
    elf::{self, FileHeader64},
    read::elf::{Dyn, FileHeader, Rela, SectionHeader, Sym},
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

/// Functions of FMI 2.0 that take no instance and so have no state to be legal in.
const WITHOUT_INSTANCE: [&str; 3] = ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate"];

/// The dynamic side of a shared library.
#[derive(Debug)]
pub(crate) struct Library {
    machine: elf::Machine,
    exports: BTreeSet<String>,
    /// Own symbols that it looks up when it is loaded, where another library's may come first.
    interposable: BTreeSet<String>,
    needed: BTreeSet<String>,
    versions: BTreeSet<String>,
}

impl Library {
    /// Reads an ELF file of 64 bits.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self> {
        let header = FileHeader64::<LittleEndian>::parse(bytes)?;
        let endian = header.endian()?;
        ensure!(header.e_type(endian) == elf::ET_DYN, "it is no shared object");
        let sections = header.sections(endian, bytes)?;
        let symbols = sections.symbols(endian, bytes, elf::SHT_DYNSYM)?;
        let text = |name: &[u8]| String::from_utf8_lossy(name).into_owned();

        let mut exports = BTreeSet::new();
        for symbol in symbols.iter() {
            if symbol.st_name(endian) != 0 && !symbol.is_undefined(endian) && !symbol.is_local() {
                exports.insert(text(symbol.name(endian, symbols.strings())?));
            }
        }
        let mut interposable = BTreeSet::new();
        for section in sections.iter() {
            let Some((relocations, _)) = section.rela(endian, bytes)? else { continue };
            for relocation in relocations {
                if let Some(index) = relocation.symbol(endian, false) {
                    let symbol = symbols.symbol(index)?;
                    if !symbol.is_undefined(endian) && !symbol.is_local() {
                        interposable.insert(text(symbol.name(endian, symbols.strings())?));
                    }
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
        let machine = header.e_machine(endian);
        Ok(Self { machine, exports, interposable, needed, versions })
    }

    /// What holds for every FMU: the machine of its folder, FMI's symbols only, none of them
    /// looked up elsewhere.
    pub(crate) fn check(&self, platform: &Platform) -> Result<()> {
        ensure!(
            self.machine == platform.machine,
            "it is built for machine {:?} of ELF, binaries/{} is for {:?}",
            self.machine,
            platform.folder(),
            platform.machine
        );
        let standard: BTreeSet<String> = Call::ALL
            .iter()
            .map(|call| call.name())
            .chain(WITHOUT_INSTANCE)
            .map(str::to_owned)
            .collect();
        if let Some(name) = self.exports.symmetric_difference(&standard).next() {
            match standard.contains(name) {
                true => bail!("it does not export {name}"),
                false => bail!("it exports {name}, which is no function of FMI 2.0"),
            }
        }
        if let Some(name) = self.interposable.first() {
            bail!("it looks up its own {name} when loaded, and may find another library's");
        }
        Ok(())
    }

    /// What holds for those that are shipped: no library but glibc, and an old one will do.
    pub(crate) fn check_portable(&self) -> Result<()> {
        if let Some(name) = self.needed.iter().find(|name| !GLIBC_PARTS.contains(&name.as_str())) {
            bail!("it needs {name}, which a machine may not have");
        }
        if let Some(version) = self.versions.iter().find(|version| !is_old(version)) {
            bail!("it needs {version}; {GLIBC} is the newest glibc that may be asked for");
        }
        Ok(())
    }

    /// The symbols it shows.
    #[cfg(test)]
    pub(crate) fn exports(&self) -> impl Iterator<Item = &str> {
        self.exports.iter().map(String::as_str)
    }

    /// Its own symbols that another library's could take the place of.
    #[cfg(test)]
    pub(crate) fn interposable(&self) -> impl Iterator<Item = &str> {
        self.interposable.iter().map(String::as_str)
    }

    /// The newest glibc it asks for.
    pub(crate) fn glibc(&self) -> String {
        let newest = self.versions.iter().filter_map(|version| glibc(version)).max();
        newest.map(|[major, minor, _]| format!("{major}.{minor}")).unwrap_or_default()
    }
}

/// Whether a symbol version is one of a glibc no newer than [`GLIBC`].
fn is_old(version: &str) -> bool {
    glibc(version).is_some_and(|numbers| Some(numbers) <= glibc(&format!("GLIBC_{GLIBC}")))
}

/// The numbers in `GLIBC_2.17`, `GLIBC_2.2.5`.
fn glibc(version: &str) -> Option<[u32; 3]> {
    let mut numbers = version.strip_prefix("GLIBC_")?.split('.').map(str::parse);
    let mut next = || numbers.next().unwrap_or(Ok(0)).ok();
    Some([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::platform;

    type Change = fn(&mut Library);

    fn set(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn fit() -> Library {
        let exports = Call::ALL.iter().map(|call| call.name()).chain(WITHOUT_INSTANCE);
        Library {
            machine: elf::EM_X86_64,
            exports: exports.map(str::to_owned).collect(),
            interposable: BTreeSet::new(),
            needed: set(&["libc.so.6", "ld-linux-x86-64.so.2"]),
            versions: set(&["GLIBC_2.2.5", "GLIBC_2.14", "GLIBC_2.17"]),
        }
    }

    #[test]
    fn a_library_that_is_not_fit_is_told_why() {
        let linux64 = platform::named("linux64").unwrap();
        let judge = |change: Change| {
            let mut library = fit();
            change(&mut library);
            library.check(linux64).and_then(|()| library.check_portable())
        };
        assert_eq!(fit().exports.len(), 44);
        judge(|_| ()).unwrap();
        let cases: [(Change, &str); 7] = [
            (|l| l.machine = elf::EM_AARCH64, "binaries/linux64 is for"),
            (|l| l.exports = set(&["fmi2Reset"]), "does not export fmi2CancelStep"),
            (|l| l.exports.extend(set(&["rust_eh_personality"])), "exports rust_eh_personality"),
            (|l| l.interposable = set(&["fmi2Reset"]), "looks up its own fmi2Reset"),
            (|l| l.needed.extend(set(&["libgcc_s.so.1"])), "needs libgcc_s.so.1"),
            (|l| l.versions.extend(set(&["GLIBC_2.18"])), "needs GLIBC_2.18"),
            (|l| l.versions.extend(set(&["GCC_3.0"])), "needs GCC_3.0"),
        ];
        for (change, part) in cases {
            let error = judge(change).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
