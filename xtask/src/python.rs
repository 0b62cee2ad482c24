//! The Python side of the tests: a virtual environment under target/ with pinned packages.

use crate::{paths, process};
use anyhow::{Context, Result};
use std::{fs, path::PathBuf, process::Command};

/// Makes or refreshes `target/venv` and returns its interpreter.
pub(crate) fn environment() -> Result<PathBuf> {
    let folder = paths::target().join("venv");
    let requirements = paths::root().join("tests/python/requirements.txt");
    let wanted = fs::read_to_string(&requirements)
        .with_context(|| format!("cannot read {}", requirements.display()))?;
    let interpreter = folder.join("bin/python");
    let installed = folder.join("installed.txt");
    if fs::read_to_string(&installed).is_ok_and(|present| present == wanted) {
        return Ok(interpreter);
    }
    process::run(Command::new("python3").args(["-m", "venv"]).arg(&folder))
        .context("a Python 3.11 or later with the venv module is needed for the Python tests")?;
    process::run(
        Command::new(&interpreter)
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"])
            .arg(&requirements),
    )?;
    fs::write(&installed, wanted)?;
    Ok(interpreter)
}
