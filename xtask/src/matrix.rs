//! `cargo xtask matrix`: the campaign `examples/campaign/matrix.toml`, and its verdicts as the page
//! `docs/how-to/fault-matrix.md`, which is committed.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::{package, paths, process};

const CAMPAIGN: &str = "examples/campaign/matrix.toml";
const PAGE: &str = "docs/how-to/fault-matrix.md";
/// The figure of the table.
const FIGURE: &str = "ate";

/// Makes the campaign, or the rest of it, and writes the page.
pub(crate) fn run() -> Result<()> {
    package::for_this_machine()?;
    process::run(&mut process::build_workspace())?;
    let results = paths::target().join("matrix");
    let mut command = Command::new(paths::target().join("release/cosim"));
    command.args(["campaign", CAMPAIGN, "--quiet", "--output-dir"]).arg(&results);
    let status = command.current_dir(paths::root()).status()?;
    // Missed or undecided thresholds are the subject of the page.
    ensure!(matches!(status.code(), Some(0 | 1 | 4)), "the campaign ended with {status}");
    let file = results.join("summary.json");
    let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    fs::write(paths::root().join(PAGE), page(&serde_json::from_str(&text)?)?)?;
    println!("written: {PAGE}");
    Ok(())
}

/// The table's contents, by system, scenario and filter.
type Cells = BTreeMap<String, BTreeMap<String, BTreeMap<String, String>>>;

fn page(summary: &Value) -> Result<String> {
    let mut systems = Cells::new();
    for verdict in list(summary, "verdicts").filter(|verdict| verdict["figure"] == FIGURE) {
        let cell = verdict["cell"].as_str().context("a verdict without a cell")?;
        let [system, filter, scenario] = cell.split('/').collect::<Vec<_>>()[..] else {
            anyhow::bail!("{CAMPAIGN}: '{cell}' is no cell of the matrix");
        };
        let value = verdict["quantile"]["value"].as_f64();
        let value = value.map_or_else(|| "∞".to_owned(), |value| format!("{value:.2}"));
        let mark = match verdict["answer"].as_str() {
            Some("pass") => "",
            Some("fail") => " ✗",
            _ => " ?",
        };
        let row = systems.entry(system.to_owned()).or_default().entry(scenario.to_owned());
        row.or_default().insert(filter.to_owned(), format!("{value}{mark}"));
    }
    let runs = list(summary, "verdicts").filter_map(|verdict| verdict["runs"].as_u64());
    let seeds = runs.min().unwrap_or(0);
    let bound = list(summary, "verdicts").find_map(|verdict| verdict["threshold"].as_str());
    let mut page = format!(
        "# What does each fault do to each filter?\n\n\
         Written by `cargo xtask matrix` from the campaign [`matrix.toml`](../../{CAMPAIGN}), {} runs:\n\
         {seeds} missions of 120 s in each cell, with the filter in the loop and the same random numbers for all. Each cell shows the \
         median absolute\ntrajectory error (m, not aligned). The threshold is: {}. ✗ means missed with 95 % \
         confidence, ? undecided by these runs.\n[The scenario files](campaigns.md#faults) define the faults.\n",
        summary["runs"],
        bound.context("no thresholds")?
    );
    for (system, scenarios) in &systems {
        let filters: Vec<&String> = scenarios.values().flat_map(BTreeMap::keys).collect();
        let filters: std::collections::BTreeSet<&String> = filters.into_iter().collect();
        let names = filters.iter().map(|name| breakable(name)).collect::<Vec<_>>().join(" | ");
        writeln!(page, "\n## In the system {system}\n\n| scenario | {names} |")?;
        writeln!(page, "|---|{}", "---|".repeat(filters.len()))?;
        for (scenario, row) in scenarios {
            let cells = filters.iter().map(|f| row.get(*f).map_or("", String::as_str));
            let cells = cells.collect::<Vec<_>>().join(" | ");
            writeln!(page, "| {} | {cells} |", scenario.replace('_', " "))?;
        }
    }
    Ok(page)
}

/// The name with places where a narrow column may break it.
fn breakable(name: &str) -> String {
    let inner = name.char_indices().filter(|(at, c)| *at > 0 && c.is_uppercase());
    let mut broken = name.to_owned();
    inner.rev().for_each(|(at, _)| broken.insert_str(at, "<wbr>"));
    broken
}

fn list<'a>(summary: &'a Value, name: &str) -> impl Iterator<Item = &'a Value> {
    summary[name].as_array().into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_its_median_and_what_is_said_of_it() {
        let verdict = |cell: &str, value: f64, answer: Value| {
            serde_json::json!({"cell": cell, "figure": "ate", "threshold": "median at most 1", "runs": 1,
                "answer": answer, "quantile": {"value": value}})
        };
        let summary = serde_json::json!({"runs": 3, "verdicts": [
            verdict("s/A/fix_outage", 0.456, "pass".into()),
            verdict("s/NavB/fix_outage", 2.0, "fail".into()),
            verdict("s/A/nan", 1.0, serde_json::json!({"undecided": 5})),
        ]});
        let page = page(&summary).unwrap();
        assert!(page.contains("| scenario | A | Nav<wbr>B |\n|---|---|---|\n| fix outage | 0.46 | 2.00 ✗ |\n| nan | 1.00 ? |  |"), "{page}");
    }
}
