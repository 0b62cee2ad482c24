//! Packaging: one library, nine FMUs and the paper's system, the same bytes every time.

use crate::{describe, paths, process};
use anyhow::{Context, Result};
use fmu_kit::kernel::Entry;
use std::{
    fs::{self, File},
    io::Write,
    path::{Path, PathBuf},
};
use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

/// FMI 2.0 platform folder of the machine this is built on.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
const PLATFORM: &str = "linux64";
/// FMI 2.0.4 platform tuple of the machine this is built on.
#[cfg(all(target_os = "linux", target_arch = "aarch64"))]
const PLATFORM: &str = "aarch64-linux";

/// Builds the library and writes target/fmus/*.fmu and target/fmus/paper.ssp.
pub(crate) fn run() -> Result<()> {
    process::run(&mut process::cargo(&["build", "--release", "--quiet", "-p", "rexrov-fmu"]))?;
    let library = paths::target().join("release/librexrov_fmu.so");
    let library = fs::read(&library).with_context(|| library.display().to_string())?;
    fs::create_dir_all(paths::fmus())?;
    let mut packaged = Vec::new();
    for entry in rexrov_fmu::REGISTRY.entries() {
        packaged.push(fmu(entry, &library)?);
    }
    ssp(&paths::root().join("examples/paper.ssd"), &packaged)?;
    println!("{} FMUs and paper.ssp in {}", packaged.len(), paths::fmus().display());
    Ok(())
}

/// Writes one FMU: description first, as the standard recommends for streaming.
fn fmu(entry: &Entry, library: &[u8]) -> Result<PathBuf> {
    let name = entry.info().name;
    let mut files = vec![
        ("modelDescription.xml".to_owned(), describe::text(entry)?.into_bytes()),
        (format!("binaries/{PLATFORM}/{name}.so"), library.to_vec()),
        ("documentation/index.html".to_owned(), entry.documentation().into_bytes()),
    ];
    for license in ["LICENSE-APACHE", "LICENSE-MIT"] {
        let text = fs::read(paths::root().join(license))?;
        files.push((format!("documentation/licenses/{license}"), text));
    }
    let path = paths::fmus().join(format!("{name}.fmu"));
    archive(&path, &files)?;
    Ok(path)
}

/// Writes the system package: the description with its FMUs beside it under resources/.
fn ssp(description: &Path, fmus: &[PathBuf]) -> Result<()> {
    let text = fs::read_to_string(description)
        .with_context(|| description.display().to_string())?
        .replace("\"../target/fmus/", "\"resources/");
    let mut files = vec![("SystemStructure.ssd".to_owned(), text.into_bytes())];
    for path in fmus {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        files.push((format!("resources/{name}"), fs::read(path)?));
    }
    let stem = description.file_stem().unwrap_or_default().to_string_lossy();
    archive(&paths::fmus().join(format!("{stem}.ssp")), &files)
}

/// Writes a zip file with fixed times and permissions, so that equal input gives equal bytes. It
/// appears under its name when it is whole: somebody may be reading the old one.
fn archive(path: &Path, files: &[(String, Vec<u8>)]) -> Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let partial = path.with_extension("partial");
    let file = File::create(&partial).with_context(|| partial.display().to_string())?;
    let mut zip = ZipWriter::new(file);
    for (name, bytes) in files {
        zip.start_file(name.as_str(), options)?;
        zip.write_all(bytes)?;
    }
    zip.finish()?;
    fs::rename(&partial, path).with_context(|| path.display().to_string())
}
