//! `cargo xtask bench`: figures of speed as ratios within one run, so that a slow machine or a busy
//! one changes both sides alike. Nothing here is a test: the bars are goals, shown beside what was
//! measured.

mod course;
mod filter;
mod timer;
mod vehicle;

use crate::process;
use anyhow::Result;

/// A line of the result.
struct Row {
    what: String,
    value: String,
    /// The goal, in words.
    goal: &'static str,
}

/// Measures everything and prints it.
pub(crate) fn run() -> Result<()> {
    let mut rows = Vec::new();
    rows.extend(vehicle::measure()?);
    rows.extend(filter::measure()?);
    rows.extend(course::measure()?);
    let width = rows.iter().map(|row| row.what.chars().count()).max().unwrap_or(0);
    for row in &rows {
        println!("{:width$}  {:>14}  {}", row.what, row.value, row.goal);
    }
    process::run(&mut process::cargo(&["bench", "--quiet", "-p", "cosim", "--bench", "chain"]))
}
