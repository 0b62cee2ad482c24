//! The folders of binaries (section 2.3.1).

/// The folders for a platform by its names in [`std::env::consts`]: first FMI 2.0's own if there is
/// one, last the tuple that 2.0.4 adopted from FMI 3.0 (section 2.5.1.4.1); none if the standard
/// does not name it.
#[must_use]
pub fn folders(os: &str, arch: &str) -> &'static [&'static str] {
    match (os, arch) {
        ("linux", "x86") => &["linux32", "x86-linux"],
        ("linux", "x86_64") => &["linux64", "x86_64-linux"],
        ("linux", "arm") => &["aarch32-linux"],
        ("linux", "aarch64") => &["aarch64-linux"],
        ("windows", "x86") => &["win32", "x86-windows"],
        ("windows", "x86_64") => &["win64", "x86_64-windows"],
        ("windows", "arm") => &["aarch32-windows"],
        ("windows", "aarch64") => &["aarch64-windows"],
        ("macos", "x86") => &["darwin32", "x86-darwin"],
        ("macos", "x86_64") => &["darwin64", "x86_64-darwin"],
        ("macos", "aarch64") => &["aarch64-darwin"],
        _ => &[],
    }
}
