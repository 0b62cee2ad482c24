//! The platforms an FMU can be shipped for: Linux on several machines, by the names that Rust, FMI and
//! ELF have for them.

use anyhow::{Result, anyhow};
use fmu_kit::package;
use object::elf::{EM_AARCH64, EM_X86_64, Machine};
use std::env::consts::{ARCH, OS};

/// One platform.
#[derive(Debug, PartialEq)]
pub(crate) struct Platform {
    /// The processor, as Rust calls it.
    pub(crate) arch: &'static str,
    /// `e_machine` of ELF.
    pub(crate) machine: Machine,
}

/// All of them. A line more is a platform more, if Rust and Zig both know it.
const ALL: [Platform; 2] = [
    Platform { arch: "x86_64", machine: EM_X86_64 },
    Platform { arch: "aarch64", machine: EM_AARCH64 },
];

impl Platform {
    /// Folder under binaries/.
    pub(crate) fn folder(&self) -> String {
        package::platform("linux", self.arch)
    }

    /// Rust's target.
    pub(crate) fn target(&self) -> String {
        format!("{}-unknown-linux-gnu", self.arch)
    }
}

/// The platform of a folder or of a Rust target.
pub(crate) fn named(name: &str) -> Result<&'static Platform> {
    ALL.iter().find(|platform| platform.folder() == name || platform.target() == name).ok_or_else(
        || {
            let known =
                ALL.map(|platform| format!("{} ({})", platform.folder(), platform.target()));
            anyhow!("no platform is called \"{name}\"; there are {}", known.join(", "))
        },
    )
}

/// The machine this runs on.
pub(crate) fn host() -> Result<&'static Platform> {
    named(&package::platform(OS, ARCH))
}
