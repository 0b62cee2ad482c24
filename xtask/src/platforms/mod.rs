//! `cargo xtask platforms`: the components compute the same on every platform, bit for bit.
//!
//! A driver in C (`xtask/platforms/driver.c`) steps the library of each platform with the same
//! random inputs, saves, serializes and restores states, makes invalid calls, and writes down all
//! the results: on this machine, under Wine, and under qemu-user. The outputs are compared line by
//! line.
//!
//! | file | contents |
//! |---|---|
//! | `plan` | the inputs, the same for all platforms |
//! | `machine` | how a program of another platform is run here |
//! | `location` | file locations, as each system spells them |
//! | `compare` | the comparison, and the first line that differs |
//!
//! `target/platforms/<platform>` contains library, driver and plans: copied to a real machine,
//! `driver jobs.txt` does the same there, and `--results` compares its output.

/// The component that panics on command.
#[allow(unreachable_pub, reason = "public in the library that it is a part of")]
#[path = "../../../fmu/tests/clumsy/src/component.rs"]
pub(crate) mod clumsy;

mod compare;
mod location;
mod machine;
mod plan;

use crate::{
    debian,
    package::{
        self,
        compile::{self, Linker},
        platform::{self, Platform},
        toolchain::{self, Toolchain},
    },
    paths, process,
};
use anyhow::{Context, Result, bail, ensure};
use compare::Findings;
use machine::Machine;
use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

/// What to compare.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Steps of each component
    #[arg(long, default_value_t = 3000)]
    steps: u32,
    /// Seed of the inputs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Short form for continuous integration: 300 steps, without what cannot be downloaded within
    /// four minutes
    #[arg(long, conflicts_with_all = ["steps", "seed", "offline", "prepare", "results"])]
    short: bool,
    /// Download nothing: use only what is already there
    #[arg(long)]
    offline: bool,
    /// Prepare `target/platforms/<platform>` for other machines, and run nothing but this machine's own
    #[arg(long)]
    prepare: bool,
    /// Compare what the driver wrote on a real machine: a platform and the folder brought back from
    /// there, `win64=FOLDER`
    #[arg(long, value_name = "PLATFORM=FOLDER")]
    results: Vec<String>,
}

/// Time limit for downloads in continuous integration; anything later is skipped.
const PATIENCE: Duration = Duration::from_secs(240);
/// Steps and seed of the table in the documents.
const DOCUMENTED: (u32, u64) = (3000, 1);
/// Steps in continuous integration.
const SHORT: u32 = 300;

/// Compares and prints the table; fails when anything differs, not when something could not be run.
pub(crate) fn run(options: &Options) -> Result<()> {
    if options.short {
        return in_short();
    }
    if !options.offline
        && let Err(reason) = toolchain::install()
    {
        println!("no other compiler: {reason:#}");
    }
    compare(options)
}

/// Downloads what other platforms need, within the time that continuous integration has for it.
pub(crate) fn fetch() -> Result<()> {
    debian::within(PATIENCE, || {
        toolchain::fetch()?;
        debian::install_wine(false)?;
        debian::install_qemu(false).map(drop)
    })
}

/// The short form of continuous integration.
pub(crate) fn in_short() -> Result<()> {
    if let Err(reason) = fetch() {
        println!("skipped: other platforms: {reason:#}");
        return Ok(());
    }
    toolchain::install()?;
    let results = Vec::new();
    compare(&Options {
        steps: SHORT,
        seed: 1,
        short: false,
        offline: true,
        prepare: false,
        results,
    })
}

fn compare(options: &Options) -> Result<()> {
    let host = platform::host()?;
    let mut foreign = Vec::new();
    for text in &options.results {
        let (name, folder) = text.split_once('=').with_context(|| {
            format!("--results {text}: PLATFORM=FOLDER is wanted, as in win64=results")
        })?;
        foreign.push((platform::named(name)?, PathBuf::from(folder)));
    }
    let mut reference = None;
    let mut all = Vec::new();
    let others = platform::shipped().iter().filter(|platform| *platform != host);
    for platform in [host].into_iter().chain(others) {
        let brought = foreign.iter().find(|(of, _)| *of == platform).map(|(_, folder)| folder);
        let results = match brought {
            Some(folder) => Ok(("a real machine".to_owned(), folder.clone())),
            None => on(platform, options),
        };
        match results {
            Ok((machine, folder)) => {
                let own = folder.clone();
                let reference = reference.get_or_insert(own);
                let findings = compare::folders(reference, &folder)?;
                all.push((platform.folder(), machine, findings));
            }
            Err(reason) if platform == host => return Err(reason),
            Err(reason) => println!("not run: {}. {reason:#}", platform.folder()),
        }
    }
    print(&all);
    let differing = all.iter().find_map(|(platform, _, findings)| {
        findings.iter().find_map(|f| Some((platform, f, f.difference.as_ref()?)))
    });
    if let Some((platform, findings, difference)) = differing {
        bail!("{} on {platform}: {difference}", findings.component);
    }
    if (options.steps, options.seed) == DOCUMENTED {
        check_document(&all)?;
    }
    Ok(())
}

/// The table in the documents must match these steps and this seed.
fn check_document(all: &[(String, String, Vec<Findings>)]) -> Result<()> {
    let (page, components) = (paths::root().join("docs/platforms.md"), &rexrov_fmu::REGISTRY);
    let text = fs::read_to_string(&page).with_context(|| page.display().to_string())?;
    let present: Vec<String> = text.lines().map(|line| line.replace(',', "")).collect();
    let (_, _, findings) = all.first().context("nothing was compared")?;
    for f in findings.iter().filter(|f| components.named(&f.component).is_some()) {
        let Findings { component, steps, outputs, state_bytes, log_lines, .. } = f;
        let row = format!("| {component} | {steps} | {outputs} | {state_bytes} | {log_lines} |");
        ensure!(present.contains(&row), "{}: the row of {component} is now {row}", page.display());
    }
    Ok(())
}

/// Builds for a platform, puts everything into its folder and runs it; returns what ran it and the
/// folder of the results.
fn on(platform: &Platform, options: &Options) -> Result<(String, PathBuf)> {
    let folder = paths::target().join("platforms").join(platform.folder());
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder)?;
    // Without Zig this machine's own compiler is used, for this machine.
    let linker = match *platform == *platform::host()? {
        true => Linker::at_hand(),
        false => Linker::Zig,
    };
    if linker == Linker::Zig {
        Toolchain::of(platform)?;
    }
    let built = compile::build(linker, platform, &["-p", "rexrov-fmu", "-p", "clumsy"])?;
    for package in ["rexrov-fmu", "clumsy"] {
        let name = platform.library(package);
        fs::write(folder.join(&name), package::library(linker, platform, &built, &name)?)?;
    }
    driver(linker, platform, &folder)?;
    plan::lay_out(platform, &folder, options)?;
    if options.prepare && *platform != *platform::host()? {
        bail!("{} is ready for a machine of that platform", folder.display());
    }
    let machine = Machine::of(platform, options.offline)?;
    location::lay_out(platform, &machine, &folder)?;
    machine.run(&folder, &platform.program("driver"), "jobs.txt")?;
    Ok((machine.name(), folder))
}

/// Compiles the driver. Contraction of products and sums is off, though it computes none.
fn driver(linker: Linker, platform: &Platform, folder: &Path) -> Result<()> {
    let mut command = match linker {
        Linker::Zig => compile::c_compiler(platform)?,
        Linker::Native => std::process::Command::new("cc"),
    };
    let sources = paths::root().join("xtask/platforms");
    command.args(["-O1", "-ffp-contract=off", "-std=gnu11", "-s", "-o"]);
    command.arg(folder.join(platform.program("driver"))).arg(sources.join("driver.c"));
    if platform.os == "linux" {
        command.arg("-ldl");
    }
    process::run(&mut command)
}

fn print(all: &[(String, String, Vec<Findings>)]) {
    println!(
        "\n| platform | component | steps | outputs | bytes of state | log lines | other lines | verdict |\n\
         |---|---|--:|--:|--:|--:|--:|---|"
    );
    for (platform, machine, findings) in all {
        for f in findings {
            let verdict = if f.difference.is_some() { "DIFFERS" } else { "same" };
            println!(
                "| {platform}, {machine} | {} | {} | {} | {} | {} | {} | {verdict} |",
                f.component, f.steps, f.outputs, f.state_bytes, f.log_lines, f.other_lines
            );
        }
    }
}

/// The registry's component of a name, or the one that panics.
fn guid(name: &str) -> Result<String> {
    let entry = rexrov_fmu::REGISTRY.named(name);
    let entry = entry.with_context(|| format!("no component is called {name}"))?;
    Ok(entry.guid().to_owned())
}
