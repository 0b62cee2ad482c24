//! The platforms an FMU can be made for, with their names in Rust and FMI.

use anyhow::{Result, anyhow};
use fmu_kit::package;
use std::env::consts::{ARCH, OS};

/// One platform.
#[derive(Debug, PartialEq)]
pub(crate) struct Platform {
    /// The operating system, as Rust calls it.
    pub(crate) os: &'static str,
    /// The processor, as Rust calls it.
    pub(crate) arch: &'static str,
    /// Rust's target.
    pub(crate) target: &'static str,
}

/// The shipped ones first, then those whose FMUs can be merged with them.
const ALL: [Platform; 8] = [
    Platform { os: "linux", arch: "x86_64", target: "x86_64-unknown-linux-gnu" },
    Platform { os: "windows", arch: "x86_64", target: "x86_64-pc-windows-gnu" },
    Platform { os: "linux", arch: "aarch64", target: "aarch64-unknown-linux-gnu" },
    Platform { os: "linux", arch: "x86", target: "i686-unknown-linux-gnu" },
    Platform { os: "windows", arch: "x86", target: "i686-pc-windows-gnu" },
    Platform { os: "windows", arch: "aarch64", target: "aarch64-pc-windows-gnullvm" },
    Platform { os: "macos", arch: "x86_64", target: "x86_64-apple-darwin" },
    Platform { os: "macos", arch: "aarch64", target: "aarch64-apple-darwin" },
];

impl Platform {
    /// Folder under binaries/ in FMI 2.0.
    pub(crate) fn folder(&self) -> String {
        package::platform(self.os, self.arch)
    }

    /// Folder under binaries/ in FMI 3.0.
    pub(crate) fn tuple(&self) -> String {
        package::tuple(self.os, self.arch)
    }

    /// The file that Cargo makes from a library crate.
    pub(crate) fn library(&self, package: &str) -> String {
        let prefix = if self.os == "windows" { "" } else { "lib" };
        format!("{prefix}{}{}", package.replace('-', "_"), package::suffix(&self.folder()))
    }

    /// The file that Cargo makes from a program.
    pub(crate) fn program(&self, name: &str) -> String {
        format!("{name}{}", if self.os == "windows" { ".exe" } else { "" })
    }
}

/// The platforms that are shipped.
pub(crate) fn shipped() -> &'static [Platform] {
    &ALL[..3]
}

/// The platform of a folder (of FMI 2.0 or 3.0) or of a Rust target.
pub(crate) fn named(name: &str) -> Result<&'static Platform> {
    let names = |p: &Platform| [p.folder(), p.tuple(), p.target.to_owned()];
    ALL.iter().find(|platform| names(platform).iter().any(|known| known == name)).ok_or_else(|| {
        let known = ALL.each_ref().map(|p| format!("{} ({})", p.folder(), p.target));
        anyhow!("no platform is called \"{name}\"; there are {}", known.join(", "))
    })
}

/// The machine this runs on.
pub(crate) fn host() -> Result<&'static Platform> {
    named(&package::platform(OS, ARCH))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn platforms_are_found_by_every_name_they_have() {
        for name in ["win64", "x86_64-windows", "x86_64-pc-windows-gnu"] {
            let platform = named(name).unwrap();
            assert_eq!((platform.os, platform.arch), ("windows", "x86_64"));
            assert_eq!(platform.library("rexrov-fmu"), "rexrov_fmu.dll");
            assert_eq!(platform.program("driver"), "driver.exe");
        }
        assert_eq!(named("linux32").unwrap().library("a"), "liba.so");
        assert_eq!(named("darwin64").unwrap().library("a"), "liba.dylib");
        let error = named("win128").unwrap_err().to_string();
        assert!(error.contains("no platform is called \"win128\"; there are linux64"), "{error}");
    }

    #[test]
    fn three_platforms_are_shipped() {
        let folders: Vec<_> = shipped().iter().map(Platform::folder).collect();
        assert_eq!(folders, ["linux64", "win64", "aarch64-linux"]);
    }
}
