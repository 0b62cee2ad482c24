//! `cargo xtask fuzz`: libFuzzer with AddressSanitizer on the targets of fmu/fuzz and cosim/fuzz. What
//! it learns stays under target/fuzz, so that the next run goes on from there; the short form,
//! without nightly Rust, is among the ordinary tests.

use crate::{paths, process};
use anyhow::{Context, Result};
use std::{fs, process::Command};

/// Folders and their targets: the FMU as random callers see it, the readers of strangers' files.
const TARGETS: [(&str, &[&str]); 2] = [
    ("fmu/fuzz", &["calls", "state"]),
    (
        "cosim/fuzz",
        &[
            "archive",
            "description",
            "ssd",
            "ssp",
            "ssv",
            "osp",
            "csv",
            "mcap",
            "snapshot",
            "message",
        ],
    ),
];
/// Longest input (bytes): some hundred calls, a description of a small FMU.
const LONGEST: u32 = 8192;

/// Fuzzes each target for so many seconds; fails with the first finding.
pub(crate) fn run(seconds: u32) -> Result<()> {
    process::run(&mut nightly(&["fuzz", "--version"])).context(
        "fuzzing needs `rustup toolchain install nightly` and `cargo install cargo-fuzz`",
    )?;
    let all = TARGETS.iter().flat_map(|(folder, targets)| targets.iter().map(move |t| (folder, t)));
    for (folder, target) in all {
        let corpus = paths::target().join("fuzz").join(target);
        fs::create_dir_all(&corpus).with_context(|| corpus.display().to_string())?;
        let limits = [format!("-max_total_time={seconds}"), format!("-max_len={LONGEST}")];
        let fuzz = ["fuzz", "run", "--fuzz-dir", folder, target];
        process::run(nightly(&fuzz).arg(&corpus).args(["--", "-len_control=0"]).args(limits))?;
    }
    Ok(())
}

/// Cargo of the nightly toolchain; the one that runs us is not.
fn nightly(arguments: &[&str]) -> Command {
    let mut command = Command::new("rustup");
    command
        .args(["run", "nightly", "cargo"])
        .args(arguments)
        .current_dir(paths::root())
        .env_remove("CARGO")
        .env("CARGO_TARGET_DIR", paths::target().join("fuzz/build"));
    command
}
