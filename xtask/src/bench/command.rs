//! `cosim simulate` of one FMU as a whole process: start, unpacking, run, results, end.

use super::Row;
use crate::{package, paths, process};
use anyhow::{Context, Result};
use std::process::Command;

const REPETITIONS: u32 = 15;

pub(super) fn measure() -> Result<Vec<Row>> {
    package::run()?;
    process::run(&mut process::cargo(&["build", "--release", "--quiet", "-p", "cosim"]))?;
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
    let row = |what: &str, value: String, goal| Row { what: what.into(), value, goal };
    Ok(vec![
        row("cosim simulate RexROV.fmu, least", format!("{least:.1} ms"), "at most 20 ms"),
        row("  median", format!("{median:.1} ms"), ""),
        row("  processor time, least", format!("{processor:.1} ms"), ""),
        row("  peak memory", format!("{memory:.1} MB"), "at most 25 MB"),
    ])
}
