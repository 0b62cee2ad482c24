//! Runs that are repeated to be shown in full.

use super::cells::{Cell, ShownRun, urgency};
use super::{Bench, Campaign, Contents, Runs};
use crate::{Row, Status};
use cosim_base::error::{Error, Result};
use cosim_core::observe::Recording;
use cosim_report::{Choice, ShownAs, Trace};

/// A run to show: the position of its cell on the page, its number, and why it was chosen.
pub(super) type Planned = (usize, u64, &'static str);

/// Makes the runs.
pub(super) struct Shown<'a> {
    /// Or why no run can be made.
    pub(super) bench: Result<Bench, String>,
    pub(super) campaign: &'a Campaign,
    pub(super) contents: &'a Contents,
    /// For each cell: its rows in the order of their numbers.
    pub(super) rows: &'a [Vec<usize>],
}

/// Prepares the runs, if nothing has changed.
pub(super) fn bench(campaign: Campaign, contents: &Contents) -> Result<Bench, String> {
    let line = |error: Error| error.line();
    let bench = Bench::open(campaign).map_err(line)?;
    let now = bench.identity().map_err(line)?;
    let changed = contents.identity.iter().find(|line| !now.contains(line));
    match changed.or_else(|| now.iter().find(|line| !contents.identity.contains(line))) {
        None => Ok(bench),
        Some(line) => Err(format!("something has changed since then: {line}")),
    }
}

/// The runs of all cells: first the worst of each, urgent cells before others.
pub(super) fn plan(cells: &[Cell<'_>]) -> Vec<Planned> {
    let mut plan: Vec<(usize, u8, Planned)> = Vec::new();
    for (position, cell) in cells.iter().enumerate() {
        let chosen = cell.chosen.iter().enumerate();
        plan.extend(chosen.map(|(rank, (run, why))| (rank, urgency(cell), (position, *run, *why))));
    }
    plan.sort_by_key(|(rank, urgency, _)| (*rank, *urgency));
    plan.into_iter().map(|(_, _, planned)| planned).collect()
}

impl Shown<'_> {
    /// The runs by number, with at most this many octets in total; records them in the cells.
    pub(super) fn make(
        &self,
        plan: &[Planned],
        octets: usize,
        cells: &mut [Cell<'_>],
        more: &mut dyn FnMut(usize) -> bool,
    ) -> Runs {
        let mut runs = Runs::new();
        // Its own run may be longer than others, but none needs more than this.
        let each = (octets / plan.len().max(1)).min(400_000);
        let mut stopped = false;
        for (place, (cell, run, why)) in plan.iter().enumerate() {
            stopped = stopped || !more(plan.len() - place);
            let made = if stopped {
                Err("the report was interrupted".to_owned())
            } else {
                self.trace(*run, each)
            };
            let row = self.row(*run);
            cells[*cell].shown.push(ShownRun {
                run: *run,
                why,
                digest: row.map_or(String::new(), |row| row.digest.to_string()),
                problem: made.as_ref().err().cloned(),
            });
            runs.extend(made.ok().map(|trace| (run.to_string(), trace)));
        }
        runs
    }

    fn row(&self, run: u64) -> Option<Row> {
        let (rows, runs) = (&self.rows[self.campaign.cell_of(run)], self.contents.rows.runs());
        let place = rows.binary_search_by_key(&run, |at| runs[*at]).ok()?;
        self.contents.logged(&rows[place..=place]).ok()?.pop()
    }

    fn trace(&self, run: u64, most: usize) -> Result<Trace, String> {
        let bench = self.bench.as_ref().map_err(Clone::clone)?;
        let (all, mut recording) = (["*".to_owned()], Recording::new());
        let again = bench.replay(run, &all, &mut recording);
        let before = self.row(run).ok_or("its row is missing")?;
        if again.status != Status::Ok {
            return Err(format!("it fails now: {}", again.reason));
        }
        if again.digest != before.digest {
            return Err(format!("it gives a different result now: its digest is {}", again.digest));
        }
        let line = |error: Error| error.line();
        let mut choice = Choice::default();
        let count = self.campaign.summarized().len();
        bench.figures(run)[..count].iter().for_each(|figure| figure.choose(&mut choice));
        let shown = ShownAs {
            units: bench.units(run, &all).map_err(line)?,
            choice,
            faults: bench.windows(run, &recording),
            ..ShownAs::default()
        };
        Trace::within(&recording, shown, most).map_err(line)
    }
}
