//! Paths: everything is relative to the workspace root, and all output goes under the target
//! folder.

use std::path::{Path, PathBuf};

/// Workspace root.
pub(crate) fn root() -> &'static Path {
    // xtask/ is directly below the root.
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// Output folder of cargo, of the packaged FMUs and of the reports.
pub(crate) fn target() -> PathBuf {
    root().join("target")
}

/// Folder of the packaged FMUs.
pub(crate) fn fmus() -> PathBuf {
    target().join("fmus")
}

/// Cargo's output folder for a target of Rust, or for this machine.
pub(crate) fn released(triple: Option<&str>) -> PathBuf {
    target().join(triple.unwrap_or_default()).join("release")
}

/// The libraries of the FMUs that `cosim` writes, for a platform by its folder in an FMU.
pub(crate) fn libraries(platform: &str) -> PathBuf {
    target().join("lib/cosim").join(platform)
}
