//! `cargo xtask judge`: the results of independent tools for the packaged FMUs and for `cosim`, as
//! one table of tool, check and FMU.

use crate::package::{self, platform};
use crate::{paths, process, python};
use anyhow::Result;
use cosim::{Overrides, System, export::Export};
use std::{fs, process::Command};

/// Packages, runs every judge, prints the table; fails if one judge fails.
pub(crate) fn run() -> Result<()> {
    package::for_shipping()?;
    export_loop()?;
    process::run(&mut process::build_workspace())?;
    in_rust()?;
    in_python()
}

/// The importer `fmi-rs`, in a workspace of its own.
pub(crate) fn in_rust() -> Result<()> {
    let manifest = "tests/fmi_rs/Cargo.toml";
    process::run(&mut process::cargo(&["fmt", "--check", "--manifest-path", manifest]))?;
    let test = ["test", "--release", "--quiet", "--manifest-path", manifest];
    process::run(process::cargo(&test).env("CARGO_TARGET_DIR", paths::target().join("fmi_rs")))
}

/// The Python tests that load FMUs and systems into other tools.
pub(crate) const TESTS: &str = "tests/python/judges";

/// Runs them.
pub(crate) fn in_python() -> Result<()> {
    let mut command = Command::new(python::TESTS.interpreter()?);
    command.args(["-m", "pytest", "-q", TESTS]).current_dir(paths::root());
    match python::COFMUPY.interpreter() {
        Ok(python) => {
            command.env("COFMUPY", python);
        }
        Err(why) => eprintln!("CoFmuPy is no judge here: {why:#}"),
    }
    process::run(&mut command)
}

/// Exports the paper's loop as one FMU, target/judges/Loop.fmu, to be judged with the packaged
/// ones.
pub(crate) fn export_loop() -> Result<()> {
    let system = System::load(paths::root().join("examples/paper.ssd"), &Overrides::new())?;
    let library = paths::target().join("lib/cosim").join(platform::host()?.folder());
    let folder = paths::target().join("judges");
    fs::create_dir_all(&folder)?;
    let export = Export::new().name("Loop").library(library.join("libcosim_system.so"));
    export.write(&system, folder.join("Loop.fmu"))?;
    Ok(())
}
