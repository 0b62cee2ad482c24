//! Packaging: one library, its FMUs and the systems of them, the same bytes every time; the
//! libraries of the FMUs that `cosim` writes; and for the wheel `cosim` and `rexrov-smooth`.
//!
//! | file | contents |
//! |---|---|
//! | `platform` | the platforms and their names |
//! | `compile` | libraries and program, linked for any machine or for this one |
//! | `toolchain` | the compiler that has Rust's standard library for a platform |
//! | `library` | what a library exports and needs, checked before it is packed |
//! | `contents`, `page`, `icon` | the contents of an FMU besides description and library |
//! | `reference`, `stimulus` | the run whose result an FMU contains |
//! | `archive`, `merge` | zip files; FMUs of several platforms in one |
//! | `sums` | the SHA-256 of each file |
//! | `wheel` | FMUs, system and the programs as a Python package |

pub(crate) mod archive;
pub(crate) mod compile;
pub(crate) mod contents;
pub(crate) mod icon;
mod library;
mod merge;
pub(crate) mod page;
pub(crate) mod platform;
pub(crate) mod reference;
#[cfg(test)]
mod shipped;
pub(crate) mod stimulus;
mod sums;
pub(crate) mod toolchain;
pub(crate) mod wheel;

use crate::{paths, process};
use anyhow::{Context, Result, ensure};
use compile::Linker;
use library::Library;
use platform::Platform;
use std::{
    fs,
    path::{Path, PathBuf},
};
use toolchain::Toolchain;

/// What to package.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Link with this machine's linker: needs no Python, starts only where glibc is as new
    #[arg(long, conflicts_with_all = ["target", "merge", "all"])]
    native: bool,
    /// Build for every shipped platform, as far as this machine can: `cargo xtask toolchain`
    /// installs what is needed
    #[arg(long, conflicts_with_all = ["target", "merge"])]
    all: bool,
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
        return systems(&merged, output);
    }
    if options.all {
        return for_all(output);
    }
    let linker = if options.native { Linker::Native } else { Linker::Zig };
    let platforms = match options.target.as_slice() {
        [] => vec![platform::host()?],
        names => names.iter().map(|name| platform::named(name)).collect::<Result<_>>()?,
    };
    build(linker, &platforms, output)?;
    platforms.iter().try_for_each(|platform| libraries(linker, platform))
}

/// The platforms that this machine can build for; prints what the others lack.
fn possible() -> Vec<&'static Platform> {
    let can = |platform: &&Platform| match Toolchain::of(platform) {
        Ok(_) => true,
        Err(reason) => {
            println!("{}: not built. {reason:#}", platform.folder());
            false
        }
    };
    platform::shipped().iter().filter(can).collect()
}

/// Packages the FMUs for all the platforms that this machine can build for; the libraries of the FMUs
/// that `cosim` writes are for this one.
pub(crate) fn for_all(output: &Path) -> Result<()> {
    build(Linker::Zig, &possible(), output)?;
    libraries(Linker::Zig, platform::host()?)
}

/// Packages as [`run`] does by default.
pub(crate) fn for_shipping() -> Result<()> {
    let host = platform::host()?;
    build(Linker::Zig, &[host], &paths::fmus())?;
    libraries(Linker::Zig, host)
}

/// Packages for shipping again, elsewhere; fails if a byte differs.
pub(crate) fn check_reproducible() -> Result<()> {
    let again = paths::target().join("fmus-again");
    build(Linker::Zig, &[platform::host()?], &again)?;
    let sums = |folder: &Path| fs::read_to_string(folder.join(sums::NAME)).context(sums::NAME);
    ensure!(
        sums(&paths::fmus())? == sums(&again)?,
        "packaged twice, target/fmus and target/fmus-again differ: compare their {}",
        sums::NAME
    );
    Ok(())
}

/// Packages the FMUs for use on this machine, which requires only Rust and a C compiler.
pub(crate) fn for_this_machine() -> Result<()> {
    build(Linker::at_hand(), &[platform::host()?], &paths::fmus())
}

/// Builds `cosim` for use on this machine: target/release/cosim.
pub(crate) fn program_for_this_machine() -> Result<()> {
    compile::build(Linker::Native, platform::host()?, &["-p", "cosim"]).map(|_| ())
}

/// Builds the library for all platforms, writes the FMUs and the systems.
fn build(linker: Linker, platforms: &[&'static Platform], output: &Path) -> Result<()> {
    let mut libraries = Vec::new();
    for platform in platforms {
        let built = compile::build(linker, platform, &["-p", "rexrov-fmu"])?;
        let bytes = library(linker, platform, &built, &platform.library("rexrov-fmu"))?;
        libraries.push((platform.folder(), bytes));
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
    systems(&packaged, output)
}

/// Reads one of the built libraries, if it is suitable for an FMU.
pub(crate) fn library(
    linker: Linker,
    platform: &Platform,
    built: &Path,
    name: &str,
) -> Result<Vec<u8>> {
    let (bytes, library) = checked(linker, platform, &built.join(name))?;
    library.check(platform).with_context(|| format!("{name} is not fit for an FMU"))?;
    Ok(bytes)
}

/// Reads one of the built files, if it starts on its target machines.
fn checked(linker: Linker, platform: &Platform, path: &Path) -> Result<(Vec<u8>, Library)> {
    let name = path.file_name().unwrap_or_default().display();
    let bytes = fs::read(path).with_context(|| path.display().to_string())?;
    let library = Library::read(&bytes).with_context(|| name.to_string())?;
    if linker == Linker::Zig {
        let unfit = || format!("{name} is not fit for other machines");
        library.check_portable().with_context(unfit)?;
    }
    let (folder, needs) = (platform.folder(), library.needs());
    println!("{folder}/{name}: {} bytes, needs {needs}", bytes.len());
    Ok((bytes, library))
}

/// Builds the libraries of the FMUs that `cosim` writes where it finds them: under lib/cosim/
/// beside the folder of the program. They do not contain Zenoh, which takes longer to build than
/// all the rest, and are for Linux only, as the master inside is.
fn libraries(linker: Linker, platform: &Platform) -> Result<()> {
    if platform.os != "linux" {
        println!(
            "{}: no libraries for `cosim export`, `cosim proxy`, `rexrov.component`",
            platform.folder()
        );
        return Ok(());
    }
    let folder = paths::libraries(&platform.folder());
    fs::create_dir_all(&folder)?;
    let built = compile::build(
        linker,
        platform,
        &["-p", "cosim-system", "-p", "cosim-proxy", "-p", "cosim-scripted"],
    )?;
    for name in ["libcosim_system.so", "libcosim_proxy.so", "libcosim_scripted.so"] {
        fs::write(folder.join(name), library(linker, platform, &built, name)?)?;
    }
    let licenses = contents::summary("This library", "cosim-system")?;
    fs::write(folder.join("licenses.txt"), licenses)?;
    Ok(())
}

/// Builds a program of a package of the same name. This machine's linker makes it as for the tests,
/// with the features of the whole workspace: nothing built for the tests needs to be built again.
fn program(linker: Linker, platform: &Platform, name: &str) -> Result<(Vec<u8>, Library)> {
    let built = match linker {
        Linker::Native => {
            process::run(&mut process::build_workspace())?;
            paths::released(None)
        }
        Linker::Zig => compile::build(linker, platform, &["-p", name])?,
    };
    checked(linker, platform, &built.join(name))
}

/// The systems that are written as packages.
const SYSTEMS: [&str; 2] = ["baseline", "paper"];

/// Writes the systems: each description with its FMUs beside it under resources/, in the order of
/// their names.
fn systems(fmus: &[PathBuf], output: &Path) -> Result<()> {
    let mut fmus = fmus.to_vec();
    fmus.sort();
    let mut written = fmus.clone();
    for system in SYSTEMS {
        let text = system_with_fmus_in(system, "resources")?;
        let mut files = vec![("SystemStructure.ssd".to_owned(), text.clone().into_bytes())];
        for path in &fmus {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let place = format!("resources/{name}");
            if text.contains(&format!("\"{place}\"")) {
                files.push((place, fs::read(path)?));
            }
        }
        let path = output.join(format!("{system}.ssp"));
        archive::write(&path, &files)?;
        written.push(path);
    }
    sums::write(output, &written)?;
    println!("{} FMUs, {}.ssp in {}", fmus.len(), SYSTEMS.join(".ssp, "), output.display());
    Ok(())
}

/// The description of a system, for FMUs in a folder relative to it.
fn system_with_fmus_in(name: &str, folder: &str) -> Result<String> {
    let description = paths::root().join(format!("examples/{name}.ssd"));
    let text =
        fs::read_to_string(&description).with_context(|| description.display().to_string())?;
    Ok(text.replace("\"../target/fmus/", &format!("\"{folder}/")))
}
