//! Missions, and the filters that followed them.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part of this module")]

pub mod bound;

use crate::mission::{Mission, Options, fly, parallel};
use crate::scoring::{Run, Sample, Which, run};
use crate::statistics::mean;
use rexrov::estimation::NavigationParameters;

/// The filters that reach the bound.
pub const FILTERS: [Which; 3] = [Which::Dynamic, Which::Inertial, Which::ModelAided];
/// Filters have settled (s).
pub const SETTLED: f64 = 30.0;

/// One mission of each seed.
#[derive(Default)]
pub struct Trial {
    pub missions: Vec<Mission>,
    runs: [Vec<Run>; 3],
}

impl Trial {
    /// Flies the seeds, lets `fault` change the missions, and runs the filters. The compass has no
    /// bias, and the filters know it.
    pub fn new(
        options: Options,
        seeds: impl IntoIterator<Item = u64>,
        filters: &[Which],
        fault: impl Fn(&mut Mission, u64) + Sync,
    ) -> Self {
        let unbiased = |p: &mut NavigationParameters| p.sensors.heading_bias_sigma = 0.0;
        Self::tuned(options, seeds, filters, fault, unbiased)
    }

    /// The same with other parameters.
    pub fn tuned(
        options: Options,
        seeds: impl IntoIterator<Item = u64>,
        filters: &[Which],
        fault: impl Fn(&mut Mission, u64) + Sync,
        tune: impl Fn(&mut NavigationParameters) + Sync,
    ) -> Self {
        let flown = parallel(seeds, |seed| {
            let options = Options { seed, ..options };
            let mut mission = fly(&options);
            fault(&mut mission, seed);
            let follow =
                |which| filters.contains(&which).then(|| run(which, &options, &mission, &tune));
            (FILTERS.map(follow), mission)
        });
        let mut trial = Self::default();
        for (runs, mission) in flown {
            trial.missions.push(mission);
            trial.runs.iter_mut().zip(runs).for_each(|(all, run)| all.extend(run));
        }
        trial
    }

    pub fn runs(&self, which: Which) -> &[Run] {
        &self.runs[FILTERS.iter().position(|w| *w == which).unwrap()]
    }

    /// Mean over all runs and instants from [`SETTLED`] on.
    pub fn average(&self, which: Which, f: impl Fn(&Sample) -> f64) -> f64 {
        let means = self.runs(which).iter().map(|r| r.mean(SETTLED, f64::MAX, &f));
        mean(&means.collect::<Vec<_>>())
    }

    /// Root mean square of the horizontal error from [`SETTLED`] on, all runs together.
    pub fn rmse(&self, which: Which) -> f64 {
        self.average(which, |s| s.error[0].powi(2) + s.error[1].powi(2)).sqrt()
    }
}

/// Leaves a mission as it is.
pub fn sound(_: &mut Mission, _: u64) {}
