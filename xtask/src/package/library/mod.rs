//! The requirements and exports of a shared library, read from its file: ELF of Linux, PE of
//! Windows, Mach-O of macOS.
//!
//! A shipped library exports the 44 functions of FMI 2.0 and nothing else, resolves all calls to
//! them within itself (so that two FMUs in a process never interfere), needs only what every system
//! of its kind has, and contains no debug information.

mod elf;
#[cfg(test)]
pub(crate) mod foreign;
mod macho;
mod pe;

use super::{compile::GLIBC, platform::Platform};
use anyhow::{Context, Result, bail, ensure};
use fmu_kit::{kernel::Call, package};
use object::{
    Architecture, BinaryFormat, File, Object, ObjectKind, ObjectSection, read::NameOrOrdinal,
};
use std::collections::BTreeSet;

/// Functions of FMI 2.0 that take no instance, so that no state applies to them.
const WITHOUT_INSTANCE: [&str; 3] = ["fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate"];

/// The dynamic information of a shared library.
#[derive(Debug)]
pub(crate) struct Library {
    /// Operating system and processor, as Rust calls them.
    machine: (&'static str, &'static str),
    exports: BTreeSet<String>,
    /// Own symbols that it looks up when it is loaded, where another library's may take precedence.
    interposable: BTreeSet<String>,
    /// The libraries that are loaded with it.
    needed: BTreeSet<String>,
    /// Those of them that not every system has.
    foreign: BTreeSet<String>,
    /// The glibc symbol versions that it requires.
    versions: BTreeSet<String>,
    /// Its debug information.
    debugging: BTreeSet<String>,
}

impl Library {
    /// Reads a shared library or, for Linux, a program.
    pub(crate) fn read(bytes: &[u8]) -> Result<Self> {
        let file = File::parse(bytes)?;
        ensure!(file.kind() == ObjectKind::Dynamic, "it is no shared library");
        let text = |name: &[u8]| String::from_utf8_lossy(name).into_owned();
        let (os, side) = match &file {
            File::Elf64(_) => ("linux", elf::read::<object::elf::FileHeader64<_>>(bytes)?),
            File::Elf32(_) => ("linux", elf::read::<object::elf::FileHeader32<_>>(bytes)?),
            File::Pe64(file) => ("windows", pe::read(file)?),
            File::Pe32(file) => ("windows", pe::read(file)?),
            File::MachO64(file) => ("macos", macho::read(file, bytes)?),
            _ => bail!("{:?} is no format of libraries in FMUs", file.format()),
        };
        let arch = match file.architecture() {
            Architecture::X86_64 => "x86_64",
            Architecture::I386 => "x86",
            Architecture::Aarch64 => "aarch64",
            Architecture::Arm => "arm",
            other => bail!("it is built for {other:?}, for which there are no FMUs here"),
        };
        let mut exports = side.hidden_exports;
        for export in file.exports()? {
            exports.insert(match export?.name() {
                // Mach-O prefixes C names with an underscore.
                NameOrOrdinal::Name(name) if file.format() == BinaryFormat::MachO => {
                    text(name.strip_prefix(b"_").unwrap_or(name))
                }
                NameOrOrdinal::Name(name) => text(name),
                NameOrOrdinal::Ordinal(number) => format!("number {number} without a name"),
            });
        }
        if file.format() == BinaryFormat::MachO {
            exports.retain(|name| !macho::OF_LINKER.contains(&name.as_str()));
        }
        let mut debugging = side.debugging;
        for section in file.sections() {
            let name = text(section.name_bytes()?);
            let kinds = [".debug_", ".zdebug_", "__debug_", ".stab"];
            if kinds.iter().any(|kind| name.starts_with(kind)) {
                debugging.insert(format!("section {name}"));
            }
        }
        Ok(Self {
            machine: (os, arch),
            exports,
            interposable: side.interposable,
            foreign: side.needed.iter().filter(|name| !(side.is_system)(name)).cloned().collect(),
            needed: side.needed,
            versions: side.versions,
            debugging,
        })
    }

    /// Checks for every FMU: the machine of its folder, only FMI's symbols, none of them looked up
    /// elsewhere.
    pub(crate) fn check(&self, platform: &Platform) -> Result<()> {
        let (os, arch) = self.machine;
        ensure!(
            self.machine == (platform.os, platform.arch),
            "it is built for {}, binaries/{} is for {}",
            package::tuple(os, arch),
            platform.folder(),
            platform.tuple()
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

    /// Checks for shipped FMUs: only the system's own libraries, old versions are enough, and no
    /// debug information.
    pub(crate) fn check_portable(&self) -> Result<()> {
        if let Some(name) = self.foreign.first() {
            bail!("it needs {name}, which a machine may not have");
        }
        if let Some(version) = self.versions.iter().find(|version| !is_old(version)) {
            bail!("it needs {version}; {GLIBC} is the newest glibc that may be asked for");
        }
        if let Some(leftover) = self.debugging.first() {
            bail!("it holds {leftover}, which only debuggers need: link it with `strip`");
        }
        Ok(())
    }

    /// The symbols it exports.
    #[cfg(test)]
    pub(crate) fn exports(&self) -> impl Iterator<Item = &str> {
        self.exports.iter().map(String::as_str)
    }

    /// Its own symbols that another library's could replace.
    #[cfg(test)]
    pub(crate) fn interposable(&self) -> impl Iterator<Item = &str> {
        self.interposable.iter().map(String::as_str)
    }

    /// The newest glibc it requires.
    pub(crate) fn glibc(&self) -> Result<String> {
        let newest = self.versions.iter().filter_map(|version| glibc(version)).max();
        newest.map(|[major, minor, _]| format!("{major}.{minor}")).context("it needs no glibc")
    }

    /// Its requirements, in words.
    pub(crate) fn needs(&self) -> String {
        match self.glibc() {
            Ok(glibc) => format!("glibc {glibc} or later"),
            Err(_) => Vec::from_iter(self.needed.iter().map(String::as_str)).join(", "),
        }
    }
}

/// Information that the formats store in different ways.
struct Side {
    /// Exports that [`Object::exports`] omits.
    hidden_exports: BTreeSet<String>,
    interposable: BTreeSet<String>,
    needed: BTreeSet<String>,
    versions: BTreeSet<String>,
    debugging: BTreeSet<String>,
    /// Whether every system has the library of that name.
    is_system: fn(&str) -> bool,
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
            machine: ("linux", "x86_64"),
            exports: exports.map(str::to_owned).collect(),
            interposable: BTreeSet::new(),
            needed: set(&["libc.so.6", "ld-linux-x86-64.so.2"]),
            foreign: BTreeSet::new(),
            versions: set(&["GLIBC_2.2.5", "GLIBC_2.14", "GLIBC_2.17"]),
            debugging: BTreeSet::new(),
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
        let cases: [(Change, &str); 9] = [
            (
                |l| l.machine.1 = "aarch64",
                "for aarch64-linux, binaries/linux64 is for x86_64-linux",
            ),
            (
                |l| l.machine.0 = "windows",
                "for x86_64-windows, binaries/linux64 is for x86_64-linux",
            ),
            (|l| l.exports = set(&["fmi2Reset"]), "does not export fmi2CancelStep"),
            (|l| l.exports.extend(set(&["rust_eh_personality"])), "exports rust_eh_personality"),
            (|l| l.interposable = set(&["fmi2Reset"]), "looks up its own fmi2Reset"),
            (|l| l.foreign = set(&["libgcc_s.so.1"]), "needs libgcc_s.so.1"),
            (|l| l.debugging = set(&["section .debug_info"]), "holds section .debug_info"),
            (|l| l.versions.extend(set(&["GLIBC_2.18"])), "needs GLIBC_2.18"),
            (|l| l.versions.extend(set(&["GCC_3.0"])), "needs GCC_3.0"),
        ];
        for (change, part) in cases {
            let error = judge(change).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
