//! `cargo xtask test`: every check and every test, those that fail fastest first.

use crate::{
    book, debian, describe, judge, navigate, package, paths, platforms, process, python, reproduce,
    supply,
};
use anyhow::{Result, anyhow, bail};
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

/// In this order; those of a group at the same time, because they wait for others half of the time.
const GROUPS: [&[Step]; 15] = [
    &[("format", || cargo(&["fmt", "--all", "--check"]))],
    &[
        ("lints", || cargo(&[&LINT[..], &["-D", "warnings"]].concat())),
        ("downloads for later steps", downloads),
    ],
    &[("program without its features", || {
        cargo(&["check", "--release", "-p", "cosim", "--no-default-features", "--quiet"])
    })],
    &[("documentation of the code", || {
        let doc = ["doc", "--release", "--workspace", "--no-deps", "--quiet"];
        process::run(process::cargo(&doc).env("RUSTDOCFLAGS", "-D warnings"))
    })],
    &[("licences, bans, sources", || supply::deny::run(false))],
    &[("packages of the crates", supply::publish::check)],
    &[("descriptions of the FMUs", describe::check)],
    &[("packages of the FMUs", package::for_shipping)],
    &[("reproducible packages", package::check_reproducible)],
    &[("builds of the tests", || {
        judge::export_loop()?;
        cargo(&[&TEST[..], &["--no-run", "--quiet"]].concat())
    })],
    &[("book", || book::run(true))],
    &[("experiment", || {
        let seeds = SMOKE_SEEDS;
        reproduce::run(&reproduce::Options { seeds, threads: None, paper_only: false })?;
        reproduce::check_picture()
    })],
    &[("navigation filters", || {
        let cells = SMOKE_CELLS.map(str::to_owned).to_vec();
        let seeds = SMOKE_MISSIONS;
        navigate::run(&navigate::Options { seeds, first_seed: 1, cells, threads: None })
    })],
    &[("platforms", platforms::in_short)],
    &[
        ("tests in Rust", || {
            cargo(&[&TEST[..], &["--no-fail-fast"]].concat())?;
            judge::in_rust()
        }),
        ("tests in Python and other tools", || {
            // Apart, because the judges' process contains libraries that do not tolerate others.
            judge::in_python()?;
            pytest()
        }),
    ],
];

const LINT: [&str; 6] = ["clippy", "--release", "--workspace", "--all-targets", "--quiet", "--"];

const TEST: [&str; 3] = ["test", "--release", "--workspace"];

/// Runs everything; stops after the first group in which a step fails. Prints how long each took.
pub(crate) fn run() -> Result<()> {
    let mut times = Vec::new();
    let ended = GROUPS.iter().try_for_each(|group| {
        let ended = at_once(group);
        for ((name, _), (time, _)) in group.iter().zip(&ended) {
            times.push(format!("{:6.0} s  {name}", time.as_secs_f64()));
        }
        let failed: Vec<_> = ended.into_iter().filter_map(|(_, ended)| ended.err()).collect();
        let Some((first, others)) = failed.split_first() else { return Ok(()) };
        others.iter().for_each(|why| eprintln!("{why:#}"));
        bail!("{first:#}")
    });
    println!("{}", times.join("\n"));
    ended
}

/// The steps' outcomes, and how long they took.
fn at_once(group: &[Step]) -> Vec<(Duration, Result<()>)> {
    let timed = |step: fn() -> Result<()>| {
        let begin = Instant::now();
        let ended = step();
        (begin.elapsed(), ended)
    };
    thread::scope(|scope| {
        let started: Vec<_> =
            group.iter().map(|(_, step)| scope.spawn(move || timed(*step))).collect();
        let panicked = |_| (Duration::ZERO, Err(anyhow!("a step panicked")));
        started.into_iter().map(|step| step.join().unwrap_or_else(panicked)).collect()
    })
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
    process::in_one_piece(command.current_dir(paths::root()))
}
