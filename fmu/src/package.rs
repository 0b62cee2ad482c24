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

//!
//! A packager that does more (several platforms, an icon, a reference run) combines the files
//! itself: [`fmu`] and its additions, then [`write()`].

use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

use crate::kernel::{Entry, Registry};

/// A file of an archive: its path there, with `/` between the parts, and its content.
pub type File = (String, Vec<u8>);

/// Writes the FMUs of a library beside the running program, and prints each.
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
    let libraries = [(platform(OS, ARCH), library)];
    let packaged = |entry: &Entry| {
        let mut files = fmu(entry, &libraries, "")?;
        files.extend(resources.iter().cloned());
        let path = folder.join(format!("{}.fmu", entry.info().name));
        write(&path, &files).map(|()| path)
    };
    registry.entries().map(packaged).collect()
}

/// Where Cargo puts the `cdylib` when it builds a program that depends on the library.
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

/// The files of an FMU, with the library for each platform, which its folder of binaries names. The
/// description comes first, as the standard recommends for streaming; `chapters` is HTML shown in
/// the documentation before the variables.
///
/// # Errors
/// The component cannot be described, for example because its variable table is invalid.
pub fn fmu(
    entry: &Entry,
    libraries: &[(String, Vec<u8>)],
    chapters: &str,
) -> Result<Vec<File>, String> {
    let name = entry.info().name;
    let mut files = vec![("modelDescription.xml".to_owned(), entry.describe()?.into_bytes())];
    for (platform, library) in libraries {
        let file = format!("binaries/{platform}/{name}{}", suffix(platform));
        files.push((file, library.clone()));
    }
    let page = entry.documentation(chapters).into_bytes();
    files.push(("documentation/index.html".to_owned(), page));
    Ok(files)
}

/// The folder of binaries for a platform, by its names in [`std::env::consts`]: FMI 2.0's own, or
/// the tuple that 2.0.4 adopted from FMI 3.0 (section 2.3.1).
#[must_use]
pub fn platform(os: &str, arch: &str) -> String {
    fmu_standard::folders(os, arch).first().map_or_else(|| tuple(os, arch), ToString::to_string)
}

/// The platform tuple of FMI 3.0 (section 2.5.1.4.1), by the names in [`std::env::consts`].
#[must_use]
pub fn tuple(os: &str, arch: &str) -> String {
    let folders = fmu_standard::folders(os, arch);
    folders.last().map_or_else(|| format!("{arch}-{os}"), ToString::to_string)
}

/// The file name endings of libraries in a folder of binaries.
#[must_use]
pub fn suffix(platform: &str) -> &'static str {
    match platform {
        name if name.starts_with("win") || name.ends_with("windows") => ".dll",
        name if name.contains("darwin") => ".dylib",
        _ => ".so",
    }
}

/// Writes a zip file with fixed times and permissions, so that equal files give equal bytes. It
/// appears under its name only when it is complete, because another process may be reading the old
/// one.
///
/// # Errors
/// Two files have the same path, one is too large for the format, or it cannot be written.
pub fn write(path: &Path, files: &[File]) -> Result<(), String> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let partial = path.with_extension("partial");
    let written =
        fs::File::create(&partial).map_err(zip::result::ZipError::from).and_then(|file| {
            let mut zip = ZipWriter::new(file);
            for (place, bytes) in files {
                zip.start_file(place.as_str(), options)?;
                zip.write_all(bytes)?;
            }
            zip.finish()?;
            Ok(fs::rename(&partial, path)?)
        });
    written.map_err(|cause| format!("{}: {cause}", path.display()))
}

/// The files of a folder and its subfolders, in the order of their names; none if it does not
/// exist.
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

#[cfg(test)]
mod tests {
    use super::{platform, suffix, tuple};

    #[test]
    fn platforms_have_the_names_of_the_standards() {
        for (os, arch, fmi2, fmi3, ending) in [
            ("linux", "x86", "linux32", "x86-linux", ".so"),
            ("linux", "x86_64", "linux64", "x86_64-linux", ".so"),
            ("linux", "arm", "aarch32-linux", "aarch32-linux", ".so"),
            ("linux", "aarch64", "aarch64-linux", "aarch64-linux", ".so"),
            ("windows", "x86", "win32", "x86-windows", ".dll"),
            ("windows", "x86_64", "win64", "x86_64-windows", ".dll"),
            ("windows", "aarch64", "aarch64-windows", "aarch64-windows", ".dll"),
            ("macos", "x86_64", "darwin64", "x86_64-darwin", ".dylib"),
            ("macos", "aarch64", "aarch64-darwin", "aarch64-darwin", ".dylib"),
        ] {
            assert_eq!([platform(os, arch), tuple(os, arch)], [fmi2, fmi3]);
            assert_eq!([suffix(fmi2), suffix(fmi3)], [ending; 2]);
        }
    }
}
