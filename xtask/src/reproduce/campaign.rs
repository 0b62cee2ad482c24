//! Makes all runs of the campaign on all cores.

use std::path::Path;

use anyhow::{Context, ensure};
use cosim::Recording;
use cosim::campaign::{Bench, Status};

use super::case::Case;
use super::metrics::Metrics;
use super::settings::{bench, cases};
use super::trace::{SIGNALS, Trace};
use crate::experiment::on_threads;

/// The seed whose runs are kept in full, for the figures.
pub(crate) const SHOWN_SEED: u32 = 1;

/// Seeds up to this one get result files, so that the folder stays below 250 MB.
pub(crate) const FILED_SEEDS: u32 = 20;

/// What is kept of one run.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    pub(crate) case: Case,
    pub(crate) metrics: Metrics,
    /// The signals, of the seed that the figures show.
    pub(crate) trace: Option<Trace>,
}

/// All runs, in the order of their cases.
#[derive(Debug, Clone, Default)]
pub(crate) struct Campaign {
    pub(crate) outcomes: Vec<Outcome>,
}

impl Campaign {
    /// Makes all runs on this many threads; result files of the paper's columns go into a folder.
    pub(crate) fn run(seeds: u32, threads: usize, folder: &Path) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        let bench = bench(seeds)?;
        bench.check()?;
        let outcomes = on_threads("reproduce", &cases(&bench)?, threads, |(case, run)| {
            make(&bench, case, *run, folder).with_context(|| format!("the run {case} failed"))
        })?;
        Ok(Campaign { outcomes })
    }

    /// The measures of all seeds of a kind of run.
    pub(crate) fn metrics(&self, of: impl Fn(&Case) -> bool) -> Vec<Metrics> {
        self.outcomes.iter().filter(|o| of(&o.case)).map(|o| o.metrics).collect()
    }

    /// The kept signals of a kind of run.
    pub(crate) fn trace(&self, of: impl Fn(&Case) -> bool) -> anyhow::Result<&Trace> {
        let found = self.outcomes.iter().filter(|o| of(&o.case)).find_map(|o| o.trace.as_ref());
        found.context("no signals were kept of a run that the report shows")
    }

    /// The runs that did not reach the end of their course.
    pub(crate) fn unfinished(&self) -> impl Iterator<Item = &Case> {
        self.outcomes.iter().filter(|o| o.metrics.finish_time.is_nan()).map(|o| &o.case)
    }
}

fn make(bench: &Bench, case: &Case, run: u64, folder: &Path) -> anyhow::Result<Outcome> {
    let mut recording = Recording::new();
    let row = bench.replay(run, &SIGNALS.map(str::to_owned), &mut recording);
    ensure!(row.status == Status::Ok, row.reason);
    if case.is_in_paper() && case.seed <= FILED_SEEDS {
        recording.write_csv(folder.join(case.file_name()))?;
    }
    let trace = Trace::of(&recording)?;
    let metrics = Metrics::of(&trace, &case.course.path()?);
    let trace = (case.seed == SHOWN_SEED).then_some(trace);
    Ok(Outcome { case: *case, metrics, trace })
}
