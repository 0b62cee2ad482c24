//! `cosim simulate` of one FMU as a whole process: start, unpacking, run, results, end.

use super::{Bar, Row, row};
use crate::{paths, process};
use anyhow::{Context, Result};
use std::ffi::OsStr;
use std::process::Command;

const REPETITIONS: u32 = 15;

pub(super) fn measure() -> Result<Vec<Row>> {
    process::run(&mut process::build_workspace())?;
    let fmu = paths::fmus().join("RexROV.fmu");
    let system = paths::root().join("examples/paper.ssd");
    let short = ["--stop-time", "1", "--output-file", "/dev/null"];
    let one = cost(
        REPETITIONS,
        &[&["simulate".as_ref(), fmu.as_os_str()][..], &short.map(OsStr::new)].concat(),
    )?;
    let run = cost(
        REPETITIONS,
        &[&["run".as_ref(), system.as_os_str()][..], &short.map(OsStr::new)].concat(),
    )?;
    Ok(vec![
        row("cosim simulate RexROV.fmu, least", one.least_ms, "ms", Bar::AtMost(20.0)),
        row("  median", one.median_ms, "ms", Bar::None),
        row("  processor time, least", one.processor_ms, "ms", Bar::None),
        row("  peak memory", one.memory_mb, "MB", Bar::AtMost(25.0)),
        row("cosim run paper.ssd, 1 s, processor time", run.processor_ms, "ms", Bar::None),
    ])
}

/// The cost of a command as a whole process.
pub(super) struct Cost {
    pub(super) least_ms: f64,
    median_ms: f64,
    processor_ms: f64,
    pub(super) memory_mb: f64,
}

/// For the program `cosim` with these arguments.
pub(super) fn cost(repetitions: u32, arguments: &[&OsStr]) -> Result<Cost> {
    let output = Command::new("python3")
        .args(["-S", "-E"])
        .arg(paths::root().join("xtask/bench/process.py"))
        .arg(repetitions.to_string())
        .arg(paths::target().join("release/cosim"))
        .args(arguments)
        .output()
        .context("python3 is needed to measure a process")?;
    let text = String::from_utf8_lossy(&output.stdout);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [least_ms, median_ms, processor_ms, memory_mb] = numbers[..] else {
        anyhow::bail!("{}", String::from_utf8_lossy(&output.stderr));
    };
    Ok(Cost { least_ms, median_ms, processor_ms, memory_mb })
}
