//! `cargo xtask test`: every check and every test, those that fail fastest first.

use crate::{
    book, describe, judge, navigate, package, paths, platforms, process, python, reproduce, supply,
};
use anyhow::Result;
use std::process::Command;

/// Seeds of the experiment's short run: enough to see a goal clearly missed.
const SMOKE_SEEDS: u32 = 20;

/// Kinds of missions for which a few seeds show whether the navigation filters have changed.
const SMOKE_CELLS: [&str; 5] =
    ["BE3", "outage", "propeller-during-tactical", "smoother", "loop-HELIX"];
const SMOKE_MISSIONS: u32 = 8;

/// Runs everything; stops at the first step that fails.
pub(crate) fn run() -> Result<()> {
    process::run(&mut process::cargo(&["fmt", "--all", "--check"]))?;
    let lint = ["clippy", "--release", "--workspace", "--all-targets", "--quiet", "--"];
    process::run(&mut process::cargo(&[&lint[..], &["-D", "warnings"]].concat()))?;
    let doc = ["doc", "--release", "--workspace", "--no-deps", "--quiet"];
    process::run(process::cargo(&doc).env("RUSTDOCFLAGS", "-D warnings"))?;
    supply::deny::run(false)?;
    supply::publish::check()?;
    describe::check()?;
    package::for_shipping()?;
    package::check_reproducible()?;
    judge::export_loop()?;
    process::run(&mut process::cargo(&["test", "--release", "--workspace", "--no-fail-fast"]))?;
    judge::in_rust()?;
    book::run(true)?;
    reproduce::run(&reproduce::Options { seeds: SMOKE_SEEDS, threads: None, paper_only: false })?;
    reproduce::check_picture()?;
    let cells = SMOKE_CELLS.map(str::to_owned).to_vec();
    let seeds = SMOKE_MISSIONS;
    navigate::run(&navigate::Options { seeds, first_seed: 1, cells, threads: None })?;
    platforms::in_short()?;
    judge::in_python()?;
    // The judges' process contains libraries of other tools: not all tolerate others until it ends.
    pytest(&["tests/python", "--ignore", judge::TESTS])
}

fn pytest(arguments: &[&str]) -> Result<()> {
    let mut command = Command::new(python::TESTS.interpreter()?);
    process::run(
        command.args(["-m", "pytest", "-q", "-rfEs"]).args(arguments).current_dir(paths::root()),
    )
}
