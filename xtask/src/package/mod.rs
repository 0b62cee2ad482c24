//! Packaging: one library, nine FMUs and the paper's system, the same bytes every time.
//!
//! | file | what |
//! |---|---|
//! | `platform` | the platforms and their names |
//! | `compile` | the library, linked for any machine or for this one |
//! | `library` | what the library exports and needs, checked before it is packed |
//! | `contents`, `page`, `icon` | what lies in an FMU beside description and library |
//! | `reference`, `stimulus` | the run whose result an FMU carries |
//! | `archive`, `merge` | zip files; FMUs of several platforms in one |

mod archive;
mod compile;
pub(crate) mod contents;
pub(crate) mod icon;
mod library;
mod merge;
pub(crate) mod page;
pub(crate) mod platform;
pub(crate) mod reference;
#[cfg(test)]
mod shipped;
mod stimulus;

use crate::paths;
use anyhow::{Context, Result};
use compile::Linker;
use library::Library;
use platform::Platform;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// What to package.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Link with this machine's linker: needs no Python, starts only where glibc is as new
    #[arg(long, conflicts_with_all = ["target", "merge"])]
    native: bool,
    /// Platform to build for, may be repeated [default: the x86-64 or ARM Linux this runs on]
    #[arg(long, value_name = "PLATFORM", conflicts_with = "merge")]
    target: Vec<String>,
    /// Build nothing: merge the FMUs in these folders, each built for another platform
    #[arg(long, value_name = "FOLDER", num_args = 2..)]
    merge: Vec<PathBuf>,
    /// Where to write the FMUs
    #[arg(long, value_name = "FOLDER", default_value_os_t = paths::fmus())]
    output: PathBuf,
}

/// Packages for shipping.
pub(crate) fn run(options: &Options) -> Result<()> {
    let output = &options.output;
    if !options.merge.is_empty() {
        let merged = merge::folders(&options.merge, output)?;
        return system(&merged, output);
    }
    let linker = if options.native { Linker::Native } else { Linker::Zig };
    let platforms = match options.target.as_slice() {
        [] => vec![platform::host()?],
        names => names.iter().map(|name| platform::named(name)).collect::<Result<_>>()?,
    };
    build(linker, &platforms, output)
}

/// Packages as [`run`] does when nothing else is asked for.
pub(crate) fn for_shipping() -> Result<()> {
    build(Linker::Zig, &[platform::host()?], &paths::fmus())
}

/// Packages for use on this machine, which needs no more than Rust and a C compiler.
pub(crate) fn for_this_machine() -> Result<()> {
    build(Linker::at_hand(), &[platform::host()?], &paths::fmus())
}

/// Builds the library for all platforms, writes the FMUs and the paper's system.
fn build(linker: Linker, platforms: &[&'static Platform], output: &Path) -> Result<()> {
    let mut libraries = Vec::new();
    for platform in platforms {
        let bytes = compile::library(linker, platform, &["-p", "rexrov-fmu"], "librexrov_fmu.so")?;
        let library = Library::read(&bytes)?;
        library.check(platform).context("the library is not fit for an FMU")?;
        if linker == Linker::Zig {
            library.check_portable().context("the library is not fit for other machines")?;
        }
        let folder = platform.folder();
        println!("{folder}: {} bytes, glibc {} or later", bytes.len(), library.glibc());
        libraries.push((folder, bytes));
    }
    for platform in platforms {
        serving(linker, platform)?;
    }
    fs::create_dir_all(output)?;
    let licenses = contents::licenses()?;
    let mut packaged = Vec::new();
    for entry in rexrov_fmu::REGISTRY.entries() {
        let mut files = contents::of(entry, &libraries)?;
        files.extend(licenses.iter().cloned());
        let path = output.join(format!("{}.fmu", entry.info().name));
        archive::write(&path, &files)?;
        packaged.push(path);
    }
    system(&packaged, output)
}

/// Builds the library of exported systems where `cosim export` finds it: under lib/cosim/ beside the
/// folder of the program.
fn serving(linker: Linker, platform: &Platform) -> Result<()> {
    let name = "libcosim_system.so";
    let bytes = compile::library(linker, platform, &["-p", "cosim-system"], name)?;
    let library = Library::read(&bytes)?;
    library.check(platform).context("the library of exported systems is not fit for an FMU")?;
    if linker == Linker::Zig {
        let unfit = "the library of exported systems is not fit for other machines";
        library.check_portable().context(unfit)?;
    }
    let folder = paths::target().join("lib/cosim").join(platform.folder());
    fs::create_dir_all(&folder)?;
    fs::write(folder.join(name), &bytes)?;
    let licenses = contents::summary("This library", "cosim-system")?;
    fs::write(folder.join("licenses.txt"), licenses)?;
    println!("{}/{name}: {} bytes", folder.display(), bytes.len());
    Ok(())
}

/// Writes the paper's system: the description with its FMUs beside it under resources/, in the
/// order of their names.
fn system(fmus: &[PathBuf], output: &Path) -> Result<()> {
    let mut fmus = fmus.to_vec();
    fmus.sort();
    let description = paths::root().join("examples/paper.ssd");
    let text = fs::read_to_string(&description)
        .with_context(|| description.display().to_string())?
        .replace("\"../target/fmus/", "\"resources/");
    let mut files = vec![("SystemStructure.ssd".to_owned(), text.into_bytes())];
    for path in &fmus {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        files.push((format!("resources/{name}"), fs::read(path)?));
    }
    archive::write(&output.join("paper.ssp"), &files)?;
    println!("{} FMUs and paper.ssp in {}", fmus.len(), output.display());
    Ok(())
}
