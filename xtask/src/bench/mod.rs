//! `cargo xtask bench`: figures of speed as ratios within one run, so that a slow machine or a busy
//! one changes both sides alike. Nothing here is a test: the bars are goals, shown beside what was
//! measured.

mod command;
mod course;
mod filter;
mod timer;
mod vehicle;

use crate::{process, python};
use anyhow::Result;

/// A line of the result.
struct Row {
    what: String,
    value: String,
    /// The goal, in words.
    goal: &'static str,
}

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Also libcosim and FMPy on the same chains, and memory over 10,000 runs
    #[arg(long)]
    third_party: bool,
}

/// Measures everything and prints it.
pub(crate) fn run(options: &Options) -> Result<()> {
    let mut rows = Vec::new();
    rows.extend(vehicle::measure()?);
    rows.extend(filter::measure()?);
    rows.extend(course::measure()?);
    rows.extend(command::measure()?);
    let width = rows.iter().map(|row| row.what.chars().count()).max().unwrap_or(0);
    for row in &rows {
        println!("{:width$}  {:>14}  {}", row.what, row.value, row.goal);
    }
    let bench = |name| process::cargo(&["bench", "--quiet", "-p", "cosim", "--bench", name]);
    if !options.third_party {
        return process::run(&mut bench("chain"));
    }
    process::run(bench("chain").env("COSIM_BENCH_PYTHON", python::environment()?))?;
    process::run(&mut bench("runs"))
}
