//! Makes all runs of the campaign on all cores.

use std::path::Path;

use anyhow::{Context, ensure};
use cosim::Recording;
use cosim::campaign::{Bench, Folder, Report, Row, Status, report};

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
    /// Its row among the results of the campaign.
    pub(crate) row: Row,
    /// The signals, of the seed that the figures show.
    pub(crate) trace: Option<Trace>,
}

/// All runs, in the order of their cases.
#[derive(Debug, Clone, Default)]
pub(crate) struct Campaign {
    pub(crate) outcomes: Vec<Outcome>,
}

/// The page of the campaign whose results are in a folder, with text, tables and pictures of its
/// own.
pub(crate) fn page(folder: &Path, report_with: &Report) -> anyhow::Result<String> {
    let (page, notes) = report(folder, report_with, &mut |_| true)?;
    notes.iter().for_each(|note| println!("Note: {note}"));
    Ok(page)
}

impl Campaign {
    /// Makes all runs on this many threads; result files of the paper's columns go into a folder.
    ///
    /// The rows go into another folder, as those of `cosim campaign`.
    pub(crate) fn run(
        seeds: u32,
        threads: usize,
        folder: &Path,
        results: &Path,
    ) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        let bench = bench(seeds)?;
        bench.check()?;
        let outcomes = on_threads("reproduce", &cases(&bench)?, threads, |(case, run)| {
            make(&bench, case, *run, folder).with_context(|| format!("the run {case} failed"))
        })?;
        write(&bench, &outcomes, results)?;
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

/// Puts the rows into a new folder, in the order of their numbers.
fn write(bench: &Bench, outcomes: &[Outcome], folder: &Path) -> anyhow::Result<()> {
    if folder.exists() {
        std::fs::remove_dir_all(folder)
            .with_context(|| format!("cannot empty {}", folder.display()))?;
    }
    let identity = bench.identity()?;
    let mut results = Folder::open(folder, bench.campaign(), &identity)?;
    let mut rows: Vec<&Row> = outcomes.iter().map(|outcome| &outcome.row).collect();
    rows.sort_by_key(|row| row.run);
    rows.into_iter().try_for_each(|row| results.add(row))?;
    Ok(results.write_table(bench.campaign(), &identity, false)?)
}

fn make(bench: &Bench, case: &Case, run: u64, folder: &Path) -> anyhow::Result<Outcome> {
    let mut recording = Recording::new();
    let row = bench.replay(run, &SIGNALS.map(str::to_owned), &mut recording);
    ensure!(row.status == Status::Ok, row.reason.clone());
    if case.is_in_paper() && case.seed <= FILED_SEEDS {
        recording.write_csv(folder.join(case.file_name()))?;
    }
    let trace = Trace::of(&recording)?;
    let metrics = Metrics::of(&trace, &case.course.path()?);
    let trace = (case.seed == SHOWN_SEED).then_some(trace);
    Ok(Outcome { case: *case, metrics, row, trace })
}
