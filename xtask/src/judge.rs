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
    let fmi_rs = ["test", "--release", "--quiet", "--workspace", "--test", "fmi_rs"];
    process::run(&mut process::cargo(&fmi_rs))?;
    in_python()
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
