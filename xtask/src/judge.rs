//! `cargo xtask judge`: what independent tools say of the packaged FMUs and of `cosim`, as one table of
//! tool, check and FMU.

use crate::{package, paths, process, python};
use anyhow::Result;
use std::process::Command;

/// Packages, asks every judge, prints the table; fails when one judge does.
pub(crate) fn run() -> Result<()> {
    package::without_program()?;
    process::run(&mut process::build_cosim())?;
    let fmi_rs = ["test", "--release", "--quiet", "--workspace", "--test", "fmi_rs"];
    process::run(&mut process::cargo(&fmi_rs))?;
    process::run(
        Command::new(python::TESTS.interpreter()?)
            .args(["-m", "pytest", "-q", "tests/python/judges"])
            .current_dir(paths::root()),
    )
}
