//! Compiling shared libraries and the program for a platform.
//!
//! The linker of the machine binds to the newest symbols of its own glibc, and to libgcc. What is
//! shipped is linked by Zig instead, which has the symbols of every glibc and an unwinder to link
//! in: it starts wherever glibc is [`GLIBC`] or later.

use super::platform::Platform;
use crate::{paths, process, python::ZIG};
use anyhow::{Context, Result};
use std::{env, ffi::OsString, path::PathBuf, process::Command};

/// Oldest glibc that what is shipped starts with: the oldest that Rust's own library supports.
pub(crate) const GLIBC: &str = "2.17";

/// Who links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Linker {
    /// Zig: for any machine of the platform.
    Zig,
    /// This machine's linker: for this machine and younger ones.
    Native,
}

impl Linker {
    /// Zig if it is installed already: what needs no shipping shall not need to download it.
    pub(crate) fn at_hand() -> Self {
        if ZIG.is_installed() { Self::Zig } else { Self::Native }
    }
}

/// Builds what `selection` (arguments of `cargo build`) names; gives the folder in which it lies.
pub(crate) fn build(linker: Linker, platform: &Platform, selection: &[&str]) -> Result<PathBuf> {
    match linker {
        Linker::Native => {
            process::run(process::cargo(&["build", "--release", "--quiet"]).args(selection))?;
            Ok(paths::released(None))
        }
        Linker::Zig => {
            process::run(zig(platform)?.args(selection))?;
            Ok(paths::released(Some(&platform.target())))
        }
    }
}

/// `cargo zigbuild` for a platform, with all that it keeps under target/.
fn zig(platform: &Platform) -> Result<Command> {
    let programs = ZIG.install()?;
    let path = env::var_os("PATH").unwrap_or_default();
    let path = env::join_paths([programs.clone()].into_iter().chain(env::split_paths(&path)))?;
    let cache = ZIG.folder().join("cache");
    let mut command = Command::new(programs.join("cargo-zigbuild"));
    command
        .args(["zigbuild", "--release", "--quiet", "--target"])
        .arg(format!("{}.{GLIBC}", platform.target()))
        .current_dir(paths::root())
        .env("PATH", path)
        .env("CARGO_TARGET_DIR", paths::target())
        .env("CARGO_ENCODED_RUSTFLAGS", remapped()?)
        .env("CARGO_ZIGBUILD_CACHE_DIR", &cache)
        .env("ZIG_GLOBAL_CACHE_DIR", &cache)
        .env("ZIG_LOCAL_CACHE_DIR", &cache);
    Ok(command)
}

/// Flags that keep the builder's folders out of the library, so that it is the same from any.
fn remapped() -> Result<OsString> {
    let home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| env::home_dir().map(|home| home.join(".cargo")));
    let mut flags = OsString::new();
    for (from, to) in [(home, "cargo"), (Some(paths::root().to_owned()), ".")] {
        let from = from.context("neither CARGO_HOME nor a home folder is known")?;
        if !flags.is_empty() {
            flags.push("\x1f");
        }
        flags.push("--remap-path-prefix=");
        flags.push(from);
        flags.push("=");
        flags.push(to);
    }
    Ok(flags)
}
