//! `cargo xtask wheel`: the Python package, including everything that runs without a compiler.
//!
//! | in the wheel | after `pip install` | from |
//! |---|---|---|
//! | `rexrov/*.py` | the package | `cosim/python/rexrov/` |
//! | `rexrov/fmus/`, `systems/`, `courses/` | its data | `target/fmus`, `examples/`, `rexrov::guidance` |
//! | programs `cosim`, `rexrov-smooth` | `bin/` | `cosim/`, `fmu/smooth/`, for shipping linked by Zig |
//! | its libraries | `lib/cosim/`, where it looks for them | `target/lib/cosim` |
//!
//! All of it is first collected in `target/wheel`, which the build backend packs unchanged: the
//! same bytes every time.

use super::{
    compile::{GLIBC, Linker},
    contents, platform, sums, system_with_fmus_in,
};
use crate::{paths, process, python};
use anyhow::{Context, Result};
use rexrov::guidance::Course;
use std::{
    fs::{self, Permissions},
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::Command,
};

/// Files of the project that the wheel contains unchanged.
const COPIED: [(&str, &str); 4] = [
    ("cosim/python/pyproject.toml", "pyproject.toml"),
    ("cosim/python/hatch_build.py", "hatch_build.py"),
    ("cosim/python/README.md", "README.md"),
    ("examples/square.csv", "rexrov/courses/square.csv"),
];

/// The paper's courses, by their names in `pursuit.course`.
const COURSES: [(&str, &str); 3] =
    [("BE1", Course::BE1), ("BE2", Course::BE2), ("BE3", Course::BE3)];

/// Packages the FMUs, for all platforms on request, and builds the wheel for any machine.
pub(crate) fn run(all: bool) -> Result<()> {
    if all {
        super::for_all(&paths::fmus())?
    } else {
        super::for_shipping()?
    }
    build(Linker::Zig)
}

/// Builds the wheel from packaged FMUs for this machine and newer ones.
pub(crate) fn for_this_machine() -> Result<()> {
    build(Linker::Native)
}

fn build(linker: Linker) -> Result<()> {
    let stage = paths::target().join("wheel");
    let _ = fs::remove_dir_all(&stage);
    let host = platform::host()?;
    let (cosim, library) = super::program(linker, host, "cosim")?;
    let (smooth, _) = super::program(linker, host, "rexrov-smooth")?;
    let glibc = match linker {
        Linker::Zig => GLIBC.to_owned(),
        // The larger one needs no less.
        Linker::Native => library.glibc()?,
    };
    lay_out(&stage, &[("cosim", &cosim), ("rexrov-smooth", &smooth)])?;
    let wheels = paths::target().join("wheels");
    let _ = fs::remove_dir_all(&wheels);
    process::run(
        Command::new(python::ZIG.install()?.join("hatchling"))
            .args(["build", "-t", "wheel", "-d"])
            .arg(&wheels)
            .current_dir(&stage)
            .env("REXROV_VERSION", env!("CARGO_PKG_VERSION"))
            .env("REXROV_TAG", tag(&glibc)?),
    )?;
    sums::write(&wheels, &[built()?])
}

/// Installs the newest wheel, without its dependencies, in the environment of the tests.
pub(crate) fn install() -> Result<()> {
    let options = ["install", "--quiet", "--disable-pip-version-check", "--no-deps"];
    process::run(
        Command::new(python::TESTS.interpreter()?)
            .args(["-m", "pip"])
            .args(options)
            .arg("--force-reinstall")
            .arg(built()?),
    )
}

/// The wheel in target/wheels.
fn built() -> Result<PathBuf> {
    let folder = paths::target().join("wheels");
    let missing = || format!("no wheel in {}: run `cargo xtask wheel`", folder.display());
    let entries = fs::read_dir(&folder).with_context(missing)?.flatten();
    let mut wheels = entries.map(|entry| entry.path());
    wheels.find(|path| path.extension().is_some_and(|end| end == "whl")).with_context(missing)
}

fn lay_out(stage: &Path, programs: &[(&str, &[u8])]) -> Result<()> {
    for (from, to) in COPIED {
        write(&stage.join(to), &fs::read(paths::root().join(from)).context(from)?)?;
    }
    copy(&paths::root().join("cosim/python/rexrov"), &stage.join("rexrov"), &["py", "typed"])?;
    for license in ["LICENSE-APACHE", "LICENSE-MIT"] {
        write(&stage.join(license), &fs::read(paths::root().join(license))?)?;
    }
    let mut linked = String::new();
    for (name, _) in programs {
        linked += &format!("The program {name} contains {}\n", contents::linked(name)?);
    }
    write(&stage.join("LICENSE-LINKED"), linked.as_bytes())?;
    for entry in rexrov_fmu::REGISTRY.entries() {
        let name = format!("{}.fmu", entry.info().name);
        let fmu = fs::read(paths::fmus().join(&name)).with_context(|| name.clone())?;
        write(&stage.join("rexrov/fmus").join(&name), &fmu)?;
    }
    for (name, text) in COURSES {
        write(&stage.join(format!("rexrov/courses/{name}.csv")), text.as_bytes())?;
    }
    for name in ["baseline", "paper"] {
        let system = system_with_fmus_in(name, "../fmus")?;
        write(&stage.join(format!("rexrov/systems/{name}.ssd")), system.as_bytes())?;
    }
    let libraries = Path::new("lib/cosim").join(platform::host()?.folder());
    copy(&paths::target().join(&libraries), &stage.join(&libraries), &["so"])?;
    for (name, program) in programs {
        let file = stage.join("bin").join(name);
        write(&file, program)?;
        // pip keeps the file mode from the wheel.
        fs::set_permissions(&file, Permissions::from_mode(0o755))
            .with_context(|| file.display().to_string())?;
    }
    Ok(())
}

/// Python and platform of the wheel: any Python 3, this platform with that glibc.
fn tag(glibc: &str) -> Result<String> {
    let machine = platform::host()?.arch;
    Ok(format!("py3-none-manylinux_{}_{machine}", glibc.replace('.', "_")))
}

/// Copies the files of a folder with this ending.
fn copy(from: &Path, to: &Path, endings: &[&str]) -> Result<()> {
    for entry in fs::read_dir(from).with_context(|| from.display().to_string())? {
        let path = entry?.path();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if path.is_file() && endings.contains(&ending) {
            write(&to.join(path.file_name().unwrap_or_default()), &fs::read(&path)?)?;
        }
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(path, bytes).with_context(|| path.display().to_string())
}
