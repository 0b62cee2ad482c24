//! Runs all cases on all cores.

use std::path::{Path, PathBuf};

use anyhow::Context;
use cosim::{Recording, System};

use super::case::Case;
use super::metrics::Metrics;
use super::settings::{SYSTEM, overrides};
use super::trace::Trace;
use crate::experiment::on_threads;
use crate::paths;

/// The seed whose runs are kept whole, for the figures.
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
    /// Runs the cases on so many threads; result files of the paper's columns go into a folder.
    pub(crate) fn run(cases: &[Case], threads: usize, folder: &Path) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        // Kept while the others are derived from it, so that the FMUs are unpacked and mapped once.
        let first = cases.first().context("no case to run: ask for at least one seed")?;
        let base = System::load(system_file(), &overrides(first)?)?;
        let outcomes = on_threads("reproduce", cases, threads, |case| {
            run_case(&base, case, folder).with_context(|| format!("the run {case} failed"))
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

fn system_file() -> PathBuf {
    paths::root().join(SYSTEM)
}

fn run_case(base: &System, case: &Case, folder: &Path) -> anyhow::Result<Outcome> {
    let system = base.with(&overrides(case)?)?;
    let mut recording = Recording::new();
    system.run(&mut [&mut recording])?;
    if case.is_in_paper() && case.seed <= FILED_SEEDS {
        recording.write_csv(folder.join(case.file_name()))?;
    }
    let trace = Trace::of(&recording)?;
    let metrics = Metrics::of(&trace, &case.course.path()?);
    let trace = (case.seed == SHOWN_SEED).then_some(trace);
    Ok(Outcome { case: *case, metrics, trace })
}
