//! `cargo xtask test`: every check and every test, those that fail fastest first.

use crate::{
    book, debian, describe, judge, navigate, package, paths, platforms, process, python, reproduce,
    supply,
};
use anyhow::{Result, anyhow};
use std::path::PathBuf;
use std::process::Command;
use std::thread;
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

/// Steps one after another.
type Lane = &'static [Step];

/// In this order; the lanes of a group at the same time.
const GROUPS: [&[Lane]; 3] = [
    &[
        &[
            ("format", || cargo(&["fmt", "--all", "--check"])),
            ("lints", || cargo(&[&LINT[..], &["-D", "warnings"]].concat())),
            ("program without its features", || {
                cargo(&["check", "--release", "-p", "cosim", "--no-default-features", "--quiet"])
            }),
            ("documentation of the code", || {
                let doc = ["doc", "--release", "--workspace", "--no-deps", "--quiet"];
                process::run(process::cargo(&doc).env("RUSTDOCFLAGS", "-D warnings"))
            }),
            ("packages of the crates", supply::publish::check),
            ("descriptions of the FMUs", describe::check),
            ("builds of the tests", || cargo(&[&TEST[..], &["--no-run", "--quiet"]].concat())),
        ],
        &[("downloads for later steps", downloads)],
    ],
    &[
        &[
            ("licences, bans, sources", || supply::deny::run(false)),
            ("packages of the FMUs", package::for_shipping),
            ("reproducible packages", package::check_reproducible),
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
        ],
        // Its compilers work on one crate after another.
        &[("platforms", platforms::in_short)],
    ],
    // Alone on the machine: some of them have to be in time for others.
    &[&[
        ("tests in Rust", || {
            judge::export_loop()?;
            cargo(&[&TEST[..], &["--no-fail-fast"]].concat())
        }),
        ("importer in Rust", judge::in_rust),
        // Apart from each other, because the first process contains libraries of other tools.
        ("other tools", judge::in_python),
        ("tests in Python", pytest),
    ]],
];

const LINT: [&str; 6] = ["clippy", "--release", "--workspace", "--all-targets", "--quiet", "--"];

const TEST: [&str; 3] = ["test", "--release", "--workspace"];

/// Runs everything; stops after the first group in which a step fails. Prints how long each took.
pub(crate) fn run() -> Result<()> {
    let mut times = Vec::new();
    let ended = GROUPS.iter().try_for_each(|group| {
        let mut failed = None;
        for (time, ended) in at_once(group) {
            times.extend(time);
            match (ended, &failed) {
                (Err(why), Some(_)) => eprintln!("{why:#}"),
                (Err(why), None) => failed = Some(why),
                (Ok(()), _) => {}
            }
        }
        failed.map_or(Ok(()), Err)
    });
    println!("{}", times.join("\n"));
    ended
}

/// How long the steps of each lane took, and how the lane ended.
fn at_once(lanes: &[Lane]) -> Vec<(Vec<String>, Result<()>)> {
    thread::scope(|scope| {
        let started: Vec<_> = lanes.iter().map(|lane| scope.spawn(|| in_turn(lane))).collect();
        let panicked = |_| (Vec::new(), Err(anyhow!("a step panicked")));
        started.into_iter().map(|lane| lane.join().unwrap_or_else(panicked)).collect()
    })
}

/// The same for one lane, which ends at the first step that fails.
fn in_turn(lane: Lane) -> (Vec<String>, Result<()>) {
    let mut times = Vec::new();
    let ended = lane.iter().try_for_each(|(name, step)| {
        let begin = Instant::now();
        let ended = step();
        times.push(format!("{:6.0} s  {name}", begin.elapsed().as_secs_f64()));
        ended
    });
    (times, ended)
}

/// What later steps would otherwise wait for. Each fetches again what is missing, and knows whether
/// it can do without.
fn downloads() -> Result<()> {
    let environments =
        [&python::DENY, &python::ZIG, &python::BOOK, &python::TESTS, &python::COFMUPY];
    for environment in environments {
        if let Err(why) = environment.install() {
            println!("not fetched yet: {why:#}");
        }
    }
    for fetch in [platforms::fetch, || browser().map(drop)] {
        if let Err(why) = fetch() {
            println!("not fetched yet: {why:#}");
        }
    }
    Ok(())
}

fn cargo(arguments: &[&str]) -> Result<()> {
    process::run(&mut process::cargo(arguments))
}

/// Debian's Chromium, if the system has none.
fn browser() -> Result<Option<PathBuf>> {
    let shown = Command::new(python::TESTS.interpreter()?)
        .arg(paths::root().join("tests/python/browser.py"))
        .output()?;
    match shown.stdout.trim_ascii().is_empty() {
        true => debian::within(PATIENCE, debian::install_chromium).map(Some),
        false => Ok(None),
    }
}

fn pytest() -> Result<()> {
    let mut command = Command::new(python::TESTS.interpreter()?);
    match browser() {
        Ok(Some(browser)) => _ = command.env("CHROMIUM", browser),
        Ok(None) => {}
        Err(why) => println!("no browser: {why:#}"),
    }
    command.args(["-m", "pytest", "-q", "-rfEs", "tests/python", "--ignore", judge::TESTS]);
    process::run(command.current_dir(paths::root()))
}
