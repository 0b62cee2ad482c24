//! `cargo xtask judge`: what independent tools say of the packaged FMUs and of `cosim`, as one table of
//! tool, check and FMU.

use crate::{package, paths, process, python};
use anyhow::Result;
use std::process::Command;

/// Packages, asks every judge, prints the table; fails when one judge does.
pub(crate) fn run() -> Result<()> {
    package::for_shipping()?;
    process::run(&mut process::cargo(&[
        "build",
        "--release",
        "--quiet",
        "-p",
        "cosim",
        "-p",
        "cosim-system",
    ]))?;
    let fmi_rs = ["test", "--release", "--quiet", "-p", "rexrov-fmu", "--test", "fmi_rs"];
    process::run(&mut process::cargo(&fmi_rs))?;
    process::run(
        Command::new(python::TESTS.interpreter()?)
            .args(["-m", "pytest", "-q", "tests/python/judges"])
            .current_dir(paths::root()),
    )
}
