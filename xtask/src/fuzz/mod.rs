//! `cargo xtask fuzz`: libFuzzer with AddressSanitizer on the targets of fmu/fuzz and cosim/fuzz.
//! It starts from valid files (`seeds`), and keeps its corpus under target/fuzz, so that the next
//! run continues from there; the short form, without nightly Rust, is among the ordinary tests.

mod seeds;

use crate::{package, paths, process};
use anyhow::{Context, Result, bail};
use std::{fs, process::Command};

/// Folders, their longest inputs (bytes) and their targets: the FMU with random callers, some
/// hundred calls; the readers of third-party files, most of ours.
const TARGETS: [(&str, usize, &[&str]); 2] = [
    ("fmu/fuzz", 8 << 10, &["calls", "state", "threads"]),
    (
        "cosim/fuzz",
        64 << 10,
        &[
            "archive",
            "description",
            "ssd",
            "ssp",
            "ssv",
            "ssm",
            "ssb",
            "osp",
            "scenario",
            "campaign",
            "roles",
            "csv",
            "mcap",
            "parquet",
            "snapshot",
            "manifest",
            "frame",
            "exported",
            "kept",
            "message",
        ],
    ),
];
/// Limits for one input: seconds and MiB.
const LIMITS: [&str; 2] = ["-timeout=20", "-rss_limit_mb=2048"];

/// Fuzzes each of these targets, or all, for so many seconds; fails at the first finding.
pub(crate) fn run(seconds: u32, chosen: &[String]) -> Result<()> {
    let known: Vec<&str> = TARGETS.iter().flat_map(|(_, _, targets)| *targets).copied().collect();
    if let Some(unknown) = chosen.iter().find(|name| !known.contains(&name.as_str())) {
        bail!("there is no fuzz target '{unknown}'; there are {}", known.join(", "));
    }
    process::run(&mut nightly(&["fuzz", "--version"])).context(
        "fuzzing needs `rustup toolchain install nightly` and `cargo install cargo-fuzz`",
    )?;
    package::for_this_machine()?;
    for (folder, longest, targets) in TARGETS {
        // The dependencies that `cargo fuzz` will find, which has no such option itself.
        let manifest = format!("{folder}/Cargo.toml");
        let dependencies = ["fetch", "--quiet", "--manifest-path", &manifest];
        process::run(&mut process::cargo(&dependencies))?;
        let is_chosen = |target: &&&str| chosen.is_empty() || chosen.iter().any(|c| c == **target);
        for target in targets.iter().filter(is_chosen) {
            let own = paths::target().join("fuzz").join(target);
            let (corpus, good) = (own.join("corpus"), own.join("seeds"));
            fs::create_dir_all(&corpus).with_context(|| corpus.display().to_string())?;
            seeds::write(target, longest, &good)?;
            let limits = [format!("-max_total_time={seconds}"), format!("-max_len={longest}")];
            let mut command = nightly(&["fuzz", "run", "--fuzz-dir", folder]);
            // It includes Zenoh, which takes long to build; the readers do not need it.
            if *target == "message" {
                command.args(["--features", "distributed"]);
            }
            // New inputs go to the first folder.
            command.arg(target);
            command.args([&corpus, &good]).args(["--", "-len_control=0"]);
            process::run(command.args(LIMITS).args(limits))?;
        }
    }
    Ok(())
}

/// Cargo of the nightly toolchain; the one that runs us is not nightly.
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
