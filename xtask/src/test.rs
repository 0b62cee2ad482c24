//! `cargo xtask test`: every check and every test, those that fail fastest first.

use crate::{
    book, debian, describe, judge, navigate, package, paths, platforms, process, python, reproduce,
    supply,
};
use anyhow::Result;
use std::process::Command;
use std::time::{Duration, Instant};

/// Seeds of the experiment's short run: enough to see a goal clearly missed.
const SMOKE_SEEDS: u32 = 20;

/// Kinds of missions for which a few seeds show whether the navigation filters have changed.
const SMOKE_CELLS: [&str; 5] =
    ["BE3", "outage", "propeller-during-tactical", "smoother", "loop-HELIX"];
const SMOKE_MISSIONS: u32 = 8;

/// The most time to spend on fetching a browser.
const PATIENCE: Duration = Duration::from_secs(300);

/// What is done, with its name in the list of times.
type Step = (&'static str, fn() -> Result<()>);

/// In this order.
const STEPS: [Step; 16] = [
    ("format", || cargo(&["fmt", "--all", "--check"])),
    ("lints", || cargo(&[&LINT[..], &["-D", "warnings"]].concat())),
    ("program without its features", || {
        cargo(&["check", "--release", "-p", "cosim", "--no-default-features", "--quiet"])
    }),
    ("documentation of the code", || {
        let doc = ["doc", "--release", "--workspace", "--no-deps", "--quiet"];
        process::run(process::cargo(&doc).env("RUSTDOCFLAGS", "-D warnings"))
    }),
    ("licences, bans, sources", || supply::deny::run(false)),
    ("packages of the crates", supply::publish::check),
    ("descriptions of the FMUs", describe::check),
    ("packages of the FMUs", package::for_shipping),
    ("reproducible packages", package::check_reproducible),
    ("tests in Rust", || {
        judge::export_loop()?;
        cargo(&["test", "--release", "--workspace", "--no-fail-fast"])?;
        judge::in_rust()
    }),
    ("book", || book::run(true)),
    ("experiment", || {
        let seeds = SMOKE_SEEDS;
        reproduce::run(&reproduce::Options { seeds, threads: None, paper_only: false })?;
        reproduce::check_picture()
    }),
    ("navigation filters", || {
        let cells = SMOKE_CELLS.map(str::to_owned).to_vec();
        let seeds = SMOKE_MISSIONS;
        navigate::run(&navigate::Options { seeds, first_seed: 1, cells, threads: None })
    }),
    ("platforms", platforms::in_short),
    ("other tools", judge::in_python),
    // The judges' process contains libraries of other tools: not all tolerate others until it ends.
    ("tests in Python", || pytest(&["tests/python", "--ignore", judge::TESTS])),
];

const LINT: [&str; 6] = ["clippy", "--release", "--workspace", "--all-targets", "--quiet", "--"];

/// Runs everything; stops at the first step that fails. Prints how long each took.
pub(crate) fn run() -> Result<()> {
    let mut times = Vec::new();
    let ended = STEPS.iter().try_for_each(|(name, step)| {
        let begin = Instant::now();
        let ended = step();
        times.push(format!("{:6.0} s  {name}", begin.elapsed().as_secs_f64()));
        ended
    });
    println!("{}", times.join("\n"));
    ended
}

fn cargo(arguments: &[&str]) -> Result<()> {
    process::run(&mut process::cargo(arguments))
}

fn pytest(arguments: &[&str]) -> Result<()> {
    let python = python::TESTS.interpreter()?;
    let root = paths::root();
    let mut command = Command::new(&python);
    let found = process::output(Command::new(python).arg(root.join("tests/python/browser.py")))?;
    if found.trim().is_empty() {
        match debian::within(PATIENCE, debian::install_chromium) {
            Ok(browser) => _ = command.env("CHROMIUM", browser),
            Err(why) => println!("no browser: {why:#}"),
        }
    }
    process::run(command.args(["-m", "pytest", "-q", "-rfEs"]).args(arguments).current_dir(root))
}
