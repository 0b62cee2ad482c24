//! Compiling shared libraries and programs for a platform.
//!
//! The machine's linker binds to the newest symbols of its own glibc, and to libgcc. Shipped files
//! are linked by Zig instead, which has the symbols of every glibc, the import libraries of
//! Windows, and an unwinder to link in: on Linux they start wherever glibc is [`GLIBC`] or later.

use super::{platform::Platform, toolchain::Toolchain};
use crate::{paths, process, python::ZIG};
use anyhow::{Context, Result};
use std::{env, ffi::OsString, path::PathBuf, process::Command};

/// Oldest glibc that shipped files start with: the oldest that Rust's own library supports.
pub(crate) const GLIBC: &str = "2.17";

/// The linker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Linker {
    /// Zig: for any machine of the platform.
    Zig,
    /// This machine's linker: for this machine and newer ones.
    Native,
}

impl Linker {
    /// Zig if it is installed already: files that are not shipped need not download it.
    pub(crate) fn at_hand() -> Self {
        if ZIG.is_installed() { Self::Zig } else { Self::Native }
    }
}

/// Builds the `selection` (arguments of `cargo build`); returns the output folder.
pub(crate) fn build(linker: Linker, platform: &Platform, selection: &[&str]) -> Result<PathBuf> {
    match linker {
        Linker::Native => {
            process::run(process::cargo(&["build", "--release", "--quiet"]).args(selection))?;
            Ok(paths::released(None))
        }
        Linker::Zig => {
            let toolchain = Toolchain::of(platform)?;
            process::run(zig(platform, toolchain)?.arg(process::LOCKED).args(selection))?;
            Ok(toolchain.target().join(platform.target).join("release"))
        }
    }
}

/// `cargo zigbuild` for a platform, with all its files under target/.
pub(super) fn zig(platform: &Platform, toolchain: Toolchain) -> Result<Command> {
    let programs = ZIG.install()?;
    let path = env::var_os("PATH").unwrap_or_default();
    let path = env::join_paths([programs.clone()].into_iter().chain(env::split_paths(&path)))?;
    let mut target = platform.target.to_owned();
    if target.ends_with("-linux-gnu") {
        target += &format!(".{GLIBC}");
    }
    let mut more = Vec::from_iter(toolchain.flag(platform));
    if platform.os == "windows" {
        // The list that the compiler writes does not reach Zig.
        more.push("-Clink-arg=xtask/platforms/fmi2.def".to_owned());
    }
    let mut command = Command::new(programs.join("cargo-zigbuild"));
    command
        .args(["zigbuild", "--release", "--quiet", "--target", &target])
        .current_dir(paths::root())
        .env("PATH", path)
        .env("CARGO_ENCODED_RUSTFLAGS", flags(&more)?)
        .env("CARGO_ZIGBUILD_CACHE_DIR", ZIG.folder().join("cache"));
    // Symbols are a quarter of a library; only linux64, which is profiled here, keeps them.
    if platform.folder() != "linux64" {
        command.env("CARGO_PROFILE_RELEASE_STRIP", "symbols");
    }
    zig_caches(&mut command);
    toolchain.used_by(&mut command);
    Ok(command)
}

/// Zig's C compiler for a platform.
pub(crate) fn c_compiler(platform: &Platform) -> Result<Command> {
    let target = match platform.os {
        "linux" => format!("{}-linux-gnu.{GLIBC}", platform.arch),
        os => format!("{}-{os}", platform.arch),
    };
    let mut command = Command::new(ZIG.interpreter()?);
    command.args(["-m", "ziglang", "cc", "-target", &target]);
    zig_caches(&mut command);
    Ok(command)
}

fn zig_caches(command: &mut Command) {
    let cache = ZIG.folder().join("cache");
    command.env("ZIG_GLOBAL_CACHE_DIR", &cache).env("ZIG_LOCAL_CACHE_DIR", &cache);
}

/// Flags that keep the builder's folders out of the library, so that it is the same from any
/// folder, and others.
pub(super) fn flags(more: &[String]) -> Result<OsString> {
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
    for flag in more {
        flags.push("\x1f");
        flags.push(flag);
    }
    Ok(flags)
}
