//! `cosim simulate` of one FMU as a whole process: start, unpacking, run, results, end.

use super::{Bar, Row, row};
use crate::{paths, process};
use anyhow::{Context, Result};
use std::process::Command;

const REPETITIONS: u32 = 15;

pub(super) fn measure() -> Result<Vec<Row>> {
    process::run(&mut process::build_workspace())?;
    // Least and median wall clock and least processor time in ms, peak memory in MB.
    let output = Command::new("python3")
        .args(["-S", "-E"])
        .arg(paths::root().join("xtask/bench/process.py"))
        .arg(REPETITIONS.to_string())
        .arg(paths::target().join("release/cosim"))
        .arg("simulate")
        .arg(paths::fmus().join("RexROV.fmu"))
        .args(["--stop-time", "1", "--output-file", "/dev/null"])
        .output()
        .context("python3 is needed to measure a process")?;
    let text = String::from_utf8_lossy(&output.stdout);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [least, median, processor, memory] = numbers[..] else {
        anyhow::bail!("{}", String::from_utf8_lossy(&output.stderr));
    };
    Ok(vec![
        row("cosim simulate RexROV.fmu, least", least, "ms", Bar::AtMost(20.0)),
        row("  median", median, "ms", Bar::None),
        row("  processor time, least", processor, "ms", Bar::None),
        row("  peak memory", memory, "MB", Bar::AtMost(25.0)),
    ])
}
