//! `cargo xtask bench`: speed as ratios within one run, so that a slow or busy machine changes both
//! sides alike. Nothing here is a test: the limits are goals, shown beside the measurements.

mod campaign;
mod command;
mod component;
mod course;
mod filter;
mod functions;
mod timer;
mod vehicle;

use crate::{package, process, python};
use anyhow::Result;

/// A line of the result.
struct Row {
    what: String,
    value: f64,
    unit: &'static str,
    bar: Bar,
}

/// The goal for the value.
enum Bar {
    None,
    AtMost(f64),
    AtLeast(f64),
}

/// A line.
fn row(what: impl Into<String>, value: f64, unit: &'static str, bar: Bar) -> Row {
    Row { what: what.into(), value, unit, bar }
}

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Also libcosim, FMPy and the FMU Manipulation Toolbox on the same chains, and memory over 10,000 runs
    #[arg(long)]
    third_party: bool,
    /// Only the cost of distributed runs, beside raw TCP, and of remote FMUs, beside raw Zenoh
    #[arg(long)]
    distributed: bool,
    /// Only the cost of campaigns
    #[arg(long)]
    campaigns: bool,
    /// Only the cost of the filters, beside FilterPy if `FILTERPY_PYTHON` names a Python that has
    /// it
    #[arg(long)]
    filters: bool,
}

/// Measures everything and prints it.
pub(crate) fn run(options: &Options) -> Result<()> {
    let bench = |name| process::cargo(&["bench", "--quiet", "--workspace", "--bench", name]);
    if options.distributed {
        process::run(&mut bench("distributed"))?;
        return process::run(&mut bench("remote"));
    }
    if options.filters {
        print(&filter::measure()?);
        return Ok(());
    }
    package::for_this_machine()?;
    if options.campaigns {
        process::run(&mut process::build_workspace())?;
        print(&campaign::measure()?);
        return Ok(());
    }
    let mut rows = vehicle::measure()?;
    rows.extend(functions::bars()?);
    rows.extend(filter::measure()?);
    rows.extend(course::measure()?);
    rows.extend(command::measure()?);
    rows.extend(campaign::measure()?);
    print(&rows);
    println!();
    functions::print()?;
    if !options.third_party {
        process::run(&mut bench("chain"))?;
        return process::run(&mut bench("exported"));
    }
    let python = python::TESTS.interpreter()?;
    process::run(bench("chain").env("COSIM_BENCH_PYTHON", &python))?;
    process::run(bench("exported").env("COSIM_BENCH_PYTHON", &python))?;
    process::run(&mut bench("runs"))
}

/// Prints the lines, and those that miss their goal.
fn print(rows: &[Row]) {
    let width = rows.iter().map(|row| row.what.chars().count()).max().unwrap_or(0);
    for Row { what, value, unit, bar } in rows {
        let digits = if *value < 10.0 { 2 } else { 0 };
        let (bar, met) = match bar {
            Bar::None => (String::new(), true),
            Bar::AtMost(most) => (format!("at most {most}"), value <= most),
            Bar::AtLeast(least) => (format!("at least {least}"), value >= least),
        };
        let missed = if met { "" } else { "  MISSED" };
        println!("{what:width$}  {value:>8.digits$} {unit:6}  {bar}{missed}");
    }
}
