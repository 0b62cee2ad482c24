//! The platforms an FMU can hold a library for, by the names that FMI, Rust and ELF have for them.

use anyhow::{Result, anyhow};
use object::elf::{EM_AARCH64, EM_X86_64, Machine};

/// One platform.
#[derive(Debug, PartialEq)]
pub(crate) struct Platform {
    /// Folder under binaries/: FMI 2.0's own name, or the tuple that 2.0.4 took over from FMI 3.0.
    pub(crate) folder: &'static str,
    /// Rust's target.
    pub(crate) target: &'static str,
    /// `e_machine` of ELF.
    pub(crate) machine: Machine,
}

/// All of them. A line more is a platform more, if Rust and Zig both know it.
pub(crate) const ALL: [Platform; 2] = [
    Platform { folder: "linux64", target: "x86_64-unknown-linux-gnu", machine: EM_X86_64 },
    Platform { folder: "aarch64-linux", target: "aarch64-unknown-linux-gnu", machine: EM_AARCH64 },
];

/// The platform of a folder or of a Rust target.
pub(crate) fn named(name: &str) -> Result<&'static Platform> {
    ALL.iter().find(|platform| platform.folder == name || platform.target == name).ok_or_else(
        || {
            let known = ALL.map(|platform| format!("{} ({})", platform.folder, platform.target));
            anyhow!("no platform is called \"{name}\"; there are {}", known.join(", "))
        },
    )
}

/// The machine this runs on.
pub(crate) fn host() -> Result<&'static Platform> {
    named(&format!("{}-unknown-{}-gnu", std::env::consts::ARCH, std::env::consts::OS))
}
