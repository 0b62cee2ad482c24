//! The campaign of the paper's experiment, `examples/campaign/paper.toml`, and what its runs are.

use anyhow::{Context, Result};
use cosim::campaign::{Bench, Campaign};

use super::case::{Case, Course, Filter, Fix};
use crate::paths;

/// The campaign.
pub(crate) const CAMPAIGN: &str = "examples/campaign/paper.toml";
/// Its system.
pub(crate) const SYSTEM: &str = "examples/paper.ssd";
/// Time between recorded rows, s.
const OUTPUT_INTERVAL_S: f64 = 0.1;
/// Speed along the course (paper, section 9), m/s.
pub(crate) const SPEED_M_S: f64 = 0.3;

/// The campaign with this many seeds.
pub(crate) fn bench(seeds: u32) -> Result<Bench> {
    let mut campaign = Campaign::read(paths::root().join(CAMPAIGN))?;
    campaign.seeds = seeds as usize;
    Ok(Bench::open(campaign)?)
}

/// All runs, in the order of their cases.
pub(crate) fn cases(bench: &Bench) -> Result<Vec<(Case, u64)>> {
    of_campaign(bench.campaign())
}

fn of_campaign(campaign: &Campaign) -> Result<Vec<(Case, u64)>> {
    let runs = 0..campaign.runs();
    let mut cases: Vec<(Case, u64)> =
        runs.map(|run| Ok((case(campaign, run)?, run))).collect::<Result<_>>()?;
    cases.sort_unstable();
    Ok(cases)
}

/// The kind of a run, from the name of its cell: `paper/dynamic/BE1/fix 1.5 m`.
fn case(campaign: &Campaign, run: u64) -> Result<Case> {
    let cell = campaign.cell_name(campaign.cell_of(run));
    let found = || -> Option<Case> {
        let [_, filter, course, fix] = cell.split('/').collect::<Vec<_>>()[..] else { return None };
        let filter = Filter::ALL.into_iter().find(|known| known.name() == filter)?;
        let course = Course::ALL.into_iter().find(|known| known.name() == course)?;
        let named = |known: &Fix| format!("fix {} m", known.sigma()) == fix;
        let fix = Fix::ALL.into_iter().find(named)?;
        Some(Case { course, filter, fix, seed: campaign.replicate_of(run) as u32 + 1 })
    };
    found().with_context(|| format!("{CAMPAIGN}: '{cell}' is no case of the experiment"))
}

/// The arguments of `cosim` for one run from the root of the workspace: a command with a file, then
/// options with their values.
pub(crate) fn arguments(case: &Case) -> Result<Vec<(String, String)>> {
    let bench = bench(case.seed)?;
    let (_, run) = cases(&bench)?
        .into_iter()
        .find(|(known, _)| known == case)
        .with_context(|| format!("{case} is no run of the experiment"))?;
    let mut arguments = vec![("run".to_owned(), SYSTEM.to_owned())];
    let mut add = |option: &str, value: String| arguments.push((option.to_owned(), value));
    if case.filter != Filter::Dynamic {
        add("--replace", format!("ekf=target/fmus/{}", case.filter.fmu()));
    }
    for (name, value) in bench.start_values(run) {
        add("--start-value", format!("{name}={value}"));
    }
    add("--stop-time", stop_time(case)?.to_string());
    add("--output-interval", OUTPUT_INTERVAL_S.to_string());
    Ok(arguments)
}

/// The last instant, s: a third more than the course takes at the set speed. A vehicle that swerves
/// because of a noisy estimate needs up to a fifth more.
fn stop_time(case: &Case) -> Result<f64> {
    Ok((4.0 / 3.0 * case.course.path()?.length() / SPEED_M_S).ceil())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_runs_of_the_campaign_are_all_cases_each_once() {
        let mut campaign = Campaign::read(paths::root().join(CAMPAIGN)).unwrap();
        campaign.seeds = 3;
        let cases = of_campaign(&campaign).unwrap();
        let mut wanted = Case::all(3);
        wanted.sort_unstable();
        assert_eq!(cases.iter().map(|(case, _)| *case).collect::<Vec<_>>(), wanted);
    }
}
