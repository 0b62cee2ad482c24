//! Campaigns: missions of the paper per second, the size of a row, and how rows are summarized.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::Value;

use super::command::cost;
use super::{Bar, Row, row};
use crate::experiment::default_threads;
use crate::paths;

/// Seeds of the six cells: enough that starting the processes does not count.
const SEEDS: usize = 50;

/// All figures of the paper's missions, each until its course is finished.
const FIGURES: &str = r#"
ate = { kind = "ate", truth = "vehicle.pose", estimate = "ekf.pose" }
aligned = { kind = "ate", truth = "vehicle.pose", estimate = "ekf.pose", align = "se3" }
rpe_1s = { kind = "rpe", truth = "vehicle.pose", estimate = "ekf.pose", seconds = 1 }
rpe_10m = { kind = "rpe", truth = "vehicle.pose", estimate = "ekf.pose", metres = 10 }
drift = { kind = "drift", truth = "vehicle.pose", estimate = "ekf.pose" }
cross = { kind = "cross-track", truth = "vehicle.pose", estimate = "ekf.pose" }
heading = { kind = "rms", of = "ekf.pose.yaw", minus = "vehicle.pose.yaw", angle = true }
nees = { kind = "nees", truth = "vehicle.pose", estimate = "ekf.pose", axes = ["x", "y"], sigma = "ekf.sigma" }
beyond = { kind = "beyond", truth = "vehicle.pose", estimate = "ekf.pose", sigma = "ekf.sigma" }
settled = { kind = "settled-below", of = "ekf.pose.x", minus = "vehicle.pose.x", absolute = true, below = 1 }
"#;

pub(super) fn measure() -> Result<Vec<Row>> {
    let folder = paths::target().join("bench-campaign");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let file = folder.join("paper.toml");
    write(&file, SEEDS)?;
    let missions = (6 * SEEDS) as f64;
    let per_second = |jobs: usize| -> Result<f64> {
        Ok(missions / made(&file, &fresh(&folder.join("runs"))?, jobs)?.least_ms * 1e3)
    };
    let (one, cores) = (per_second(1)?, default_threads());
    let all = per_second(cores)?;
    let mut rows = vec![
        row("missions of the paper a second, one process", one, "1/s", Bar::None),
        row(format!("  {cores} processes"), all, "1/s", Bar::AtLeast(60.0)),
    ];
    if cores > 1 {
        let bar = Bar::AtLeast(0.95 * cores as f64);
        rows.push(row(format!("  {cores} processes over one"), all / one, "x", bar));
    }
    rows.extend(summaries(&folder, &file)?);
    Ok(rows)
}

fn write(file: &Path, seeds: usize) -> Result<()> {
    let text = format!(
        "seed = 1\nseeds = {seeds}\nstop-time = 440\noutput-interval = 0.5\n\
         stop-when = \"pursuit.finished >= 1\"\n[systems]\npaper = {:?}\n[replacements]\n\
         dynamic = {{}}\nkinematic = {{ ekf = {:?} }}\n[factors]\n\
         \"pursuit.course\" = [\"BE1\", \"BE2\", \"BE3\"]\n[figures]{FIGURES}",
        paths::root().join("examples/paper.ssd"),
        paths::fmus().join("EkfKinematic.fmu"),
    );
    fs::write(file, text).with_context(|| file.display().to_string())
}

fn fresh(folder: &Path) -> Result<PathBuf> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    Ok(folder.to_owned())
}

/// The cost of making a campaign, or the rest of one.
fn made(file: &Path, results: &Path, jobs: usize) -> Result<super::command::Cost> {
    let jobs = jobs.to_string();
    let options = ["--quiet", "--jobs", &jobs, "--output-dir"].map(OsStr::new);
    let arguments = [&["campaign".as_ref(), file.as_os_str()][..], &options];
    cost(1, &[&arguments.concat()[..], &[results.as_os_str()]].concat())
}

/// Existing rows of many runs: how long they take to read, judge and write.
fn summaries(folder: &Path, file: &Path) -> Result<Vec<Row>> {
    let log = folder.join("runs/runs.jsonl");
    let text = fs::read_to_string(&log).with_context(|| log.display().to_string())?;
    let rows: Vec<Value> = text.lines().map(serde_json::from_str).collect::<Result<_, _>>()?;
    let of = |count: usize| -> Result<super::command::Cost> {
        let mut many = String::new();
        for (run, row) in (0..count).zip(rows.iter().cycle()) {
            let mut row = row.clone();
            row["run"] = run.into();
            // No two rows are alike, otherwise a table would be smaller than with real runs.
            row["digest"] =
                format!("{:064x}", (run as u128 + 1).wrapping_mul(u128::MAX / 7)).into();
            for figure in row["figures"].as_array_mut().into_iter().flatten() {
                let value = figure.as_str().and_then(|text| text.parse::<f64>().ok());
                *figure = (value.unwrap_or(0.0) * (1.0 + run as f64 * 1e-9)).to_string().into();
            }
            writeln!(many, "{row}")?;
        }
        fs::write(&log, many)?;
        write(file, count.div_ceil(6))?;
        // The rest of the last seed is made, too.
        made(file, &folder.join("runs"), 1)?;
        made(file, &folder.join("runs"), 1)
    };
    let (few, more) = (of(1_000)?, of(100_000)?);
    let million = of(1_000_000)?;
    let size = fs::metadata(&log)?.len() as f64 / 1e6;
    let parquet = fs::metadata(folder.join("runs/runs.parquet"))?.len() as f64 / 1e6;
    Ok(vec![
        row("a row of ten figures in the log", size, "octets", Bar::None),
        row("  in the table", parquet, "octets", Bar::AtMost(300.0)),
        row("10^6 rows read, judged and written", million.least_ms / 1e3, "s", Bar::AtMost(2.0)),
        row(
            "memory at 10^5 rows over that at 10^3",
            more.memory_mb / few.memory_mb,
            "x",
            Bar::AtMost(1.5),
        ),
        row("  at 10^6", million.memory_mb / few.memory_mb, "x", Bar::None),
    ])
}
