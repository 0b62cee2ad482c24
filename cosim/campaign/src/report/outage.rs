//! How long measurements are missing: an axis for the figures of a campaign.

use serde::Serialize;

use super::Bench;

/// The outages of all runs.
#[derive(Default)]
pub(super) struct Outages {
    /// By the number of the run (s); empty if they are all the same or not known.
    by_run: Vec<f64>,
    /// For each cell: what its scenario does, without times.
    words: Vec<String>,
}

/// The outage of all runs of a cell.
#[derive(Serialize)]
pub(super) struct Outage {
    /// What the scenario does, without times: cells with the same differ only in when faults act.
    words: String,
    /// Its length (s).
    length: f64,
}

impl Outages {
    pub(super) fn of(bench: &Bench) -> Self {
        let campaign = bench.campaign();
        let by_run: Vec<f64> = (0..campaign.runs()).map(|run| bench.outage(run)).collect();
        let mut known = by_run.iter().filter(|length| !length.is_nan());
        let first = known.next();
        if known.all(|length| Some(length) == first) {
            return Self::default();
        }
        Self {
            by_run,
            words: (0..campaign.cells()).map(|cell| bench.scenario_words(cell)).collect(),
        }
    }

    /// Whether they can be an axis.
    pub(super) fn differ(&self) -> bool {
        !self.by_run.is_empty()
    }

    pub(super) fn length(&self, run: u64) -> f64 {
        usize::try_from(run).ok().and_then(|run| self.by_run.get(run)).map_or(f64::NAN, |l| *l)
    }

    /// `None` if these runs of the cell differ in it, or if it is not known.
    pub(super) fn of_cell(
        &self,
        cell: usize,
        mut runs: impl Iterator<Item = u64>,
    ) -> Option<Outage> {
        let length = self.length(runs.next()?);
        let same = !length.is_nan() && runs.all(|run| self.length(run) == length);
        let words = self.words.get(cell).filter(|_| same)?.clone();
        Some(Outage { words, length })
    }
}
