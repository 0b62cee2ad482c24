//! The goals of the navigation filters, measured: `cargo xtask navigate`.
//!
//! Missions of `examples/baseline.ssd` from packaged FMUs through the master, with many seeds for
//! each cell. In most cells the true pose steers, so that all filters see the same mission; in
//! those named after the loop the model-aided filter steers. Prints the results beside the goals
//! and beside those of an independent simulation of the same formulations, and writes
//! `target/navigate`: `table.md`, `results.csv`.
//!
//! | file | contents |
//! |---|---|
//! | `cell` | the kinds of missions |
//! | `filter`, `system` | the filters; the system with those that a cell needs |
//! | `mission` | one mission of a seed |
//! | `smoother` | the same mission smoothed |
//! | `score`, `statistic`, `bound` | measures of a mission, of many, and their lower bound |
//! | `goals` | the goals |
//! | `output` | table and file of results |

mod bound;
mod cell;
mod filter;
mod goals;
mod mission;
mod output;
mod score;
mod smoother;
mod statistic;
mod system;

use anyhow::{Context, bail, ensure};

pub(crate) use self::cell::{Cell, GRADES};
pub(crate) use self::filter::Filter;
pub(crate) use self::goals::Cells;
use self::goals::Row;
pub(crate) use self::score::Score;
use self::system::Systems;
use crate::experiment::{default_threads, on_threads};

/// Options of `navigate`.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Seeds of the main cells; the others get a third of them.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) seeds: u32,
    /// The first of them: other seeds check values that were chosen with seeds from 1 on.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) first_seed: u32,
    /// Only these cells, or those whose names begin with these.
    #[arg(long, value_delimiter = ',')]
    pub(crate) cells: Vec<String>,
    /// Missions at the same time [default: one per core].
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

/// Measures; an error if a goal is missed by more than the uncertainty of the seeds.
pub(crate) fn run(options: &Options) -> anyhow::Result<()> {
    let cells = chosen(&options.cells)?;
    let threads = options.threads.unwrap_or_else(default_threads);
    let results = fly_all(&cells, options.first_seed, options.seeds, threads)?;
    let mut rows: Vec<Row> = results.iter().flat_map(Cells::rows).collect();
    rows.extend(goals::of_losses(&results));
    output::write(&results, &rows)?;
    let missed: Vec<String> = rows
        .iter()
        .filter(|row| row.verdict.is_missed())
        .map(|Row { cell, filter, verdict, .. }| {
            let (what, value, goal) = (&verdict.what, verdict.value(), verdict.bounds());
            format!("{cell}, {filter}, {what}: {value}, goal {goal}")
        })
        .collect();
    if !missed.is_empty() {
        bail!("{} goals are missed:\n  {}", missed.len(), missed.join("\n  "));
    }
    Ok(())
}

/// The cells with these names.
fn chosen(names: &[String]) -> anyhow::Result<Vec<Cell>> {
    let all = Cell::all();
    for name in names {
        let known = || all.iter().map(|cell| cell.name.as_str()).collect::<Vec<_>>().join(", ");
        let found = all.iter().any(|cell| cell.name.starts_with(name.trim_end_matches('*')));
        ensure!(found, "there is no cell {name}; there are {}", known());
    }
    let wanted = |cell: &Cell| {
        names.is_empty()
            || names.iter().any(|name| match name.strip_suffix('*') {
                Some(start) => cell.name.starts_with(start),
                None => cell.name == *name,
            })
    };
    Ok(all.into_iter().filter(wanted).collect())
}

/// What is kept of a mission.
struct Flown {
    scores: Vec<Score>,
    bound: Option<bound::Bound>,
}

/// Flies this many seeds of all cells starting with the first, a third of them for secondary cells.
pub(crate) fn fly_all(
    cells: &[Cell],
    first: u32,
    seeds: u32,
    threads: usize,
) -> anyhow::Result<Vec<Cells<'_>>> {
    let systems = Systems::load(cells.iter().map(|cell| (cell.steering, cell.filters)))?;
    let runs: Vec<(&Cell, u32)> = cells
        .iter()
        .flat_map(|cell| (first..first + cell.seeds(seeds)).map(move |seed| (cell, seed)))
        .collect();
    if cells.iter().any(|cell| cell.smoothed) {
        smoother::build()?;
    }
    let flown = on_threads("navigate", &runs, threads, |(cell, seed)| {
        let base = systems.get((cell.steering, cell.filters))?;
        fly(base, cell, *seed, *seed == first)
            .with_context(|| format!("{}, seed {seed}, failed", cell.name))
    })?;
    let mut flown = flown.into_iter();
    let results = cells.iter().map(|cell| {
        let flown: Vec<Flown> = flown.by_ref().take(cell.seeds(seeds) as usize).collect();
        let bound = flown.first().and_then(|first| first.bound);
        let of = |i: usize| flown.iter().map(|f| f.scores[i].clone()).collect();
        let scores = cell.filters.iter().enumerate().map(|(i, filter)| (*filter, of(i))).collect();
        Cells { cell, scores, bound }
    });
    Ok(results.collect())
}

/// A mission of a seed; the first of a nominal cell has the Cramér-Rao bound.
fn fly(base: &cosim::System, cell: &Cell, seed: u32, is_first: bool) -> anyhow::Result<Flown> {
    let flight = mission::fly(base, cell, seed)?;
    let scores = cell.filters.iter().map(|filter| {
        let mut score = Score::of(&flight, cell, *filter)?;
        if let Some(heard) = &flight.heard {
            let mission = &flight.recording;
            score.smoothed = Some(smoother::smooth(heard, mission, cell, *filter, seed)?);
        }
        Ok(score)
    });
    let scores = scores.collect::<anyhow::Result<_>>()?;
    let nominal = is_first && matches!(cell.name.as_str(), "BE1" | "BE2" | "BE3");
    let bound = nominal.then(|| bound::of(&flight.recording, cell.grade)).transpose()?;
    Ok(Flown { scores, bound })
}
