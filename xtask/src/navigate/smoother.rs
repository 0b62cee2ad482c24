//! The program `rexrov-smooth` on recorded missions, as a user calls it.

use std::process::Command;

use anyhow::Context;
use cosim::Recording;
use cosim::report::root_mean_square;
use serde_json::{Map, Value};

use super::cell::Cell;
use super::filter::Filter;
use super::mission::{filter_parameters, row};
use super::score::SETTLED;
use super::system::folder;
use crate::{paths, process};

/// Inputs of a filter that a log contains.
pub(crate) const INPUTS: [&str; 7] =
    ["imu.*", "ahrs.*", "dvl.*", "fix.*", "pressure.*", "thruster[?].thrust", "propulsion.*"];

/// RMSE of the smoothed horizontal position (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Smoothed {
    /// Of the whole mission.
    pub(crate) rmse: f64,
    /// After the filter has settled.
    pub(crate) settled: f64,
    /// Within the window of the cell.
    pub(crate) window: f64,
}

/// Builds the program, in the same target folder as this one so that dependencies are shared.
pub(crate) fn build() -> anyhow::Result<()> {
    let packages = ["-p", "rexrov-smooth", "-p", "xtask"];
    process::run(process::cargo(&["build", "--release", "--quiet"]).args(packages))
}

/// Smooths a filter's inputs: `heard` has a row for each of its cycles, `mission` the truth.
pub(crate) fn smooth(
    heard: &Recording,
    mission: &Recording,
    cell: &Cell,
    filter: Filter,
    seed: u32,
) -> anyhow::Result<Smoothed> {
    let prefix = format!("{}.", filter.component());
    let inputs = heard.columns().filter(|(name, _)| {
        let input = name.strip_prefix(&prefix).unwrap_or_default();
        INPUTS.iter().any(|sensor| {
            input.starts_with(sensor.trim_end_matches(".*").trim_end_matches("[?].thrust"))
        })
    });
    let (names, columns) = inputs.map(|(name, column)| (name.to_owned(), column.to_vec())).unzip();
    let file = |ending: &str| -> anyhow::Result<_> {
        Ok(folder()?.join(format!("{}-{seed}-{}.{ending}", cell.name, filter.name())))
    };
    let (log, parameters, output) = (file("log.csv")?, file("json")?, file("smoothed.csv")?);
    Recording::from_columns(names, heard.time().to_vec(), columns).write_csv(&log)?;
    std::fs::write(&parameters, json(cell, filter, seed).to_string())
        .with_context(|| format!("cannot write {}", parameters.display()))?;
    process::quietly(
        Command::new(paths::target().join("release/rexrov-smooth"))
            .arg(&log)
            .args(["--quiet", "--filter", filter.name(), "--component", filter.component()])
            .arg("--parameters")
            .arg(&parameters)
            .arg("--output")
            .arg(&output),
    )?;
    let score = score(&Recording::read_csv(&output)?, mission, cell)?;
    [log, parameters, output].iter().try_for_each(std::fs::remove_file)?;
    Ok(score)
}

fn json(cell: &Cell, filter: Filter, seed: u32) -> Value {
    let value = |text: String| text.parse::<f64>().map_or(Value::from(text), Value::from);
    let parameters = filter_parameters(cell, filter, seed);
    Value::Object(
        parameters.into_iter().map(|(name, text)| (name, value(text))).collect::<Map<_, _>>(),
    )
}

/// Rows of both are at the same instants, multiples of the filter's interval.
fn score(smoothed: &Recording, mission: &Recording, cell: &Cell) -> anyhow::Result<Smoothed> {
    let off = |axis: &str| -> anyhow::Result<Vec<f64>> {
        let truth = mission.column(&format!("vehicle.pose.{axis}"))?;
        let estimate = smoothed.column(&format!("pose.{axis}"))?;
        smoothed
            .time()
            .iter()
            .zip(estimate)
            .map(|(time, e)| {
                let truth =
                    truth.get(row(*time)).context("the smoothed mission is longer than it was")?;
                Ok(e - truth)
            })
            .collect()
    };
    let error: Vec<f64> = off("x")?.iter().zip(off("y")?).map(|(x, y)| x.hypot(y)).collect();
    let within = |[from, to]: [f64; 2]| {
        let inside = smoothed.time().iter().zip(&error).filter(|(t, _)| (from..=to).contains(*t));
        root_mean_square(&inside.map(|(_, e)| *e).collect::<Vec<_>>())
    };
    Ok(Smoothed {
        rmse: within([0.0, f64::INFINITY]),
        settled: within([SETTLED, f64::INFINITY]),
        window: cell.window.map_or(f64::NAN, within),
    })
}
