//! The compiler that has Rust's standard library for a platform: the one that runs this, if the
//! library is installed, or Debian's, which `cargo xtask toolchain` unpacks under target/debian.
//!
//! Debian provides the library for ARM. For Windows it is compiled once from the sources that
//! Debian ships with the compiler, and put where the compiler looks for it.

use super::{
    compile,
    platform::{self, Platform},
};
use crate::{debian, paths, process};
use anyhow::{Context, Result, bail};
use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

/// A compiler with the standard library for some platform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Toolchain {
    /// The one that compiled this program.
    Own,
    /// Debian's.
    Debian,
}

impl Toolchain {
    /// The compiler to use for a platform.
    pub(crate) fn of(platform: &Platform) -> Result<Self> {
        if *platform == *platform::host()? || own_library(platform)?.is_some() {
            Ok(Self::Own)
        } else if has_library(&debian_library(platform)) {
            Ok(Self::Debian)
        } else {
            let target = platform.target;
            bail!(
                "Rust's standard library for {target} is missing: `rustup target add {target}` \
                 installs it; on Debian `cargo xtask toolchain` does without rustup"
            )
        }
    }

    /// Cargo's output folder: the builds of one compiler cannot be used by the other.
    pub(crate) fn target(self) -> PathBuf {
        match self {
            Self::Own => paths::target(),
            Self::Debian => debian::folder().join("build"),
        }
    }

    /// Additional settings for a platform.
    pub(super) fn flag(self, platform: &Platform) -> Option<String> {
        // Relative, because the build folder must not matter.
        let folder = Path::new("target/debian").join(EMPTY);
        (self == Self::Debian && platform.os == "windows")
            .then(|| format!("-Lnative={}", folder.display()))
    }

    /// Makes a call of Cargo use it.
    pub(crate) fn used_by(self, command: &mut Command) -> &mut Command {
        match self {
            Self::Own => command.env("CARGO_TARGET_DIR", self.target()),
            Self::Debian => command
                .env("CARGO_TARGET_DIR", self.target())
                .env("RUSTC", debian::rustc())
                .env("LD_LIBRARY_PATH", debian::libraries()),
        }
    }
}

/// Unpacks Debian's compiler, if the one that runs this lacks libraries.
pub(crate) fn fetch() -> Result<()> {
    let mut lacking =
        platform::shipped().iter().filter(|platform| Toolchain::of(platform).is_err());
    lacking.try_for_each(|platform| debian::install_compiler(sources(platform)))
}

/// [`fetch`], and compiles the library for Windows from Debian's sources.
pub(crate) fn install() -> Result<()> {
    fetch()?;
    for platform in platform::shipped() {
        if Toolchain::of(platform).is_err() {
            compile_library(platform)?;
        }
    }
    for platform in platform::shipped() {
        println!("{}: compiled by {}", platform.folder(), version(Toolchain::of(platform)?)?);
    }
    Ok(())
}

/// The identity of a compiler.
fn version(toolchain: Toolchain) -> Result<String> {
    let program = match toolchain {
        Toolchain::Own => env::var_os("RUSTC").unwrap_or("rustc".into()),
        Toolchain::Debian => debian::rustc().into(),
    };
    let version = process::output(toolchain.used_by(Command::new(program).arg("--version")))?;
    Ok(version.trim().to_owned())
}

/// The package with the library for a platform, or with its sources.
fn sources(platform: &Platform) -> &'static str {
    match (platform.os, platform.arch) {
        ("linux", "aarch64") => "libstd-rust-web-dev:arm64",
        ("linux", "x86_64") => "libstd-rust-web-dev:amd64",
        _ => "rust-web-src",
    }
}

/// Compiles the standard library as the only dependency of an empty crate.
fn compile_library(platform: &Platform) -> Result<()> {
    let folder = debian::folder().join("std");
    fs::create_dir_all(folder.join("src"))?;
    fs::write(folder.join("Cargo.toml"), NOTHING)?;
    fs::write(folder.join("src/lib.rs"), "#![no_std]\n")?;
    let vendored = debian::library_sources()?.join("vendor");
    let mut command = compile::zig(platform, Toolchain::Debian)?;
    // The sources of its dependencies are beside it.
    command
        .args(["-Zbuild-std=std,panic_unwind", "--config"])
        .arg("source.crates-io.replace-with=\"vendored\"")
        .arg("--config")
        .arg(format!("source.vendored.directory={vendored:?}"))
        .current_dir(&folder);
    // In pieces, so that the linker omits unused ones, for example sockets with WS2_32.dll.
    let flags = compile::flags(&["-Zfunction-sections=yes".to_owned()])?;
    command
        .env("CARGO_ENCODED_RUSTFLAGS", flags)
        .env("CARGO_TARGET_DIR", folder.join("target"))
        .env("RUSTC_BOOTSTRAP", "1");
    process::run(&mut command)?;
    let empty = debian::folder().join(EMPTY);
    fs::create_dir_all(&empty)?;
    for name in ["libssp.a", "libssp_nonshared.a"] {
        fs::write(empty.join(name), "!<arch>\n")?;
    }
    let library = debian_library(platform);
    fs::create_dir_all(&library)?;
    let built = folder.join("target").join(platform.target).join("release/deps");
    for entry in fs::read_dir(&built).with_context(|| built.display().to_string())? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default();
        let name = name.to_str().unwrap_or_default();
        if name.ends_with(".rlib") && !name.starts_with("libnothing") {
            fs::copy(&path, library.join(name))?;
        }
    }
    Ok(())
}

/// The folder of libraries that Debian's compiler links into everything for Windows. They are parts
/// of its own gcc that nothing here calls, so they are empty.
const EMPTY: &str = "stubs";

/// A crate that exists only for its dependencies.
const NOTHING: &str = "[package]\nname = \"nothing\"\nedition = \"2024\"\n\n[workspace]\n";

/// The folder of the standard library of the compiler that runs this, if it is installed.
fn own_library(platform: &Platform) -> Result<Option<PathBuf>> {
    let rustc = env::var_os("RUSTC").unwrap_or("rustc".into());
    let print = ["--print", "target-libdir", "--target", platform.target];
    let folder = process::output(Command::new(rustc).args(print).current_dir(paths::root()))?;
    let folder = PathBuf::from(folder.trim());
    Ok(has_library(&folder).then_some(folder))
}

fn debian_library(platform: &Platform) -> PathBuf {
    debian::sysroot().join("lib/rustlib").join(platform.target).join("lib")
}

/// Whether the standard library is in a folder.
fn has_library(folder: &Path) -> bool {
    let is_std = |name: &str| name.starts_with("libstd-") && name.ends_with(".rlib");
    fs::read_dir(folder).is_ok_and(|mut entries| {
        entries.any(|entry| entry.is_ok_and(|e| e.file_name().to_str().is_some_and(is_std)))
    })
}
