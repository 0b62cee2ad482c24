//! From a compiled library to FMUs; with the feature `package`.
//!
//! The whole packager of a crate with components is its `src/main.rs`:
//!
//! ```no_run
//! # use fmu_kit::{Component, Info, ParameterError, Resources};
//! # struct Nothing;
//! # impl Component for Nothing {
//! #     const INFO: Info = Info::new("Nothing", "Does nothing");
//! #     type Parameters = ();
//! #     type Inputs = ();
//! #     type Outputs = ();
//! #     type States = ();
//! #     type Memory = ();
//! #     fn new(_: &(), _: &Resources) -> Result<Self, ParameterError> {
//! #         Ok(Self)
//! #     }
//! #     fn outputs(&self, _: f64, _: &(), _: &(), _: &()) {}
//! # }
//! # mod my_crate { fmu_kit::export!(super::Nothing); }
//! fn main() -> std::process::ExitCode {
//!     fmu_kit::package::main(&my_crate::REGISTRY)
//! }
//! ```
//!
//! `cargo run --release` then compiles the library, which is a `cdylib` for the FMU and an `rlib`
//! for this program, and writes `target/fmus/<name>.fmu` for each component. The same library
//! always gives the same bytes.

use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

use crate::kernel::{Entry, Registry};

/// A file of an archive: its path there, with `/` between the parts, and its content.
pub type File = (String, Vec<u8>);

/// Writes the FMUs of a library beside the program that runs, and tells of each.
///
/// They go to the folder `fmus` of Cargo's target folder, or to the one that the command line
/// names. Files in the folder `resources` beside the author's Cargo.toml go into every FMU.
#[must_use]
pub fn main(registry: &Registry) -> ExitCode {
    match write_all(registry, std::env::args_os().nth(1).map(PathBuf::from)) {
        Ok(paths) => {
            paths.iter().for_each(|path| println!("{}", path.display()));
            ExitCode::SUCCESS
        }
        Err(reason) => {
            eprintln!("error: {reason}");
            ExitCode::FAILURE
        }
    }
}

fn write_all(registry: &Registry, folder: Option<PathBuf>) -> Result<Vec<PathBuf>, String> {
    let program = std::env::current_exe().map_err(|cause| format!("this program: {cause}"))?;
    let profile = program.parent().ok_or("this program lies in no folder")?;
    let library = read(&built_library(registry, profile)?)?;
    let folder = folder.unwrap_or_else(|| profile.with_file_name("fmus"));
    fs::create_dir_all(&folder).map_err(|cause| format!("{}: {cause}", folder.display()))?;
    let resources = match std::env::var_os("CARGO_MANIFEST_DIR") {
        Some(root) => files(&Path::new(&root).join("resources"), "resources")?,
        None => Vec::new(),
    };
    let write = |entry: &Entry| {
        let mut files = fmu(entry, &[(platform(), library.clone())])?;
        files.extend(resources.iter().cloned());
        let path = folder.join(entry.info().name).with_extension("fmu");
        // Somebody may be reading the old one: the new one appears under its name when it is whole.
        let partial = path.with_extension("partial");
        let written = fs::write(&partial, archive(&files)?);
        written
            .and_then(|()| fs::rename(&partial, &path))
            .map_err(|cause| format!("{}: {cause}", path.display()))?;
        Ok(path)
    };
    registry.entries().map(write).collect()
}

/// Where Cargo leaves the `cdylib` when it builds a program that depends on the library.
fn built_library(registry: &Registry, profile: &Path) -> Result<PathBuf, String> {
    let name = format!("{DLL_PREFIX}{}{DLL_SUFFIX}", registry.library());
    let path = profile.join("deps").join(&name);
    match path.is_file() {
        true => Ok(path),
        false => Err(format!(
            "no {name} in {}: the library needs `crate-type = [\"cdylib\", \"rlib\"]` in its \
             Cargo.toml, and this program must be run by `cargo run --release`",
            profile.join("deps").display()
        )),
    }
}

/// The files of an FMU, with the library for each platform; the description comes first, as the
/// standard recommends for streaming.
///
/// # Errors
/// The component cannot be described: its variable table cannot stand, say.
pub fn fmu(entry: &Entry, libraries: &[(String, Vec<u8>)]) -> Result<Vec<File>, String> {
    let name = entry.info().name;
    let mut files = vec![("modelDescription.xml".to_owned(), entry.describe()?.into_bytes())];
    for (platform, library) in libraries {
        let suffix = if platform.starts_with("win") { ".dll" } else { DLL_SUFFIX };
        files.push((format!("binaries/{platform}/{name}{suffix}"), library.clone()));
    }
    files.push(("documentation/index.html".to_owned(), entry.documentation().into_bytes()));
    Ok(files)
}

/// The folder of binaries for the machine this was compiled for (FMI 2.0.4, section 2.3.1).
#[must_use]
pub fn platform() -> String {
    match (OS, ARCH) {
        ("linux", "x86_64") => "linux64".to_owned(),
        ("windows", "x86_64") => "win64".to_owned(),
        ("macos", "x86_64") => "darwin64".to_owned(),
        ("macos", arch) => format!("{arch}-darwin"),
        (os, arch) => format!("{arch}-{os}"),
    }
}

/// A zip file with fixed times and permissions, so that equal files give equal bytes.
///
/// # Errors
/// Two files have the same path, or one is too large for the format.
pub fn archive(files: &[File]) -> Result<Vec<u8>, String> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, bytes) in files {
        zip.start_file(path.as_str(), options)
            .map_err(|cause| cause.to_string())
            .and_then(|()| zip.write_all(bytes).map_err(|cause| cause.to_string()))
            .map_err(|reason| format!("{path}: {reason}"))?;
    }
    zip.finish().map(Cursor::into_inner).map_err(|cause| cause.to_string())
}

/// The files of a folder and those below, in the order of their names; none if it does not exist.
fn files(folder: &Path, name: &str) -> Result<Vec<File>, String> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(Vec::new());
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        let own = path.file_name().unwrap_or_default().to_string_lossy();
        let place = format!("{name}/{own}");
        match path.is_dir() {
            true => found.extend(files(&path, &place)?),
            false => found.push((place, read(&path)?)),
        }
    }
    Ok(found)
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path).map_err(|cause| format!("{}: {cause}", path.display()))
}
