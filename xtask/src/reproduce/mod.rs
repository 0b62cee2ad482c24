//! The paper's experiment (section 9), repeated: three courses, two filters, many seeds.
//!
//! Makes the runs of the campaign `examples/campaign/paper.toml`, evaluates each as the paper does,
//! prints Tables 7 to 9 beside the paper's numbers and the verdicts of goal G1, and writes
//! `target/reproduce`: `report.html`, the page of the campaign with the paper's tables and figures;
//! `campaign`, a folder as `cosim campaign` writes it; `figures/*.svg`; `runs/*.csv`.

mod campaign;
mod case;
mod comparison;
mod figures;
mod goals;
mod metrics;
mod page;
mod paper;
mod settings;
mod tables;
mod trace;

use anyhow::{Context, bail};

use self::campaign::Campaign;
pub(crate) use self::case::Case;
use self::case::Course;
use self::figures::Figures;
use self::goals::verdicts;
pub(crate) use self::settings::arguments;
use crate::experiment::{Verdict, default_threads};
use crate::paths;

/// Options of `reproduce`.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Seeds of every course and filter; with few of them a median is too uncertain for a verdict.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) seeds: u32,
    /// Runs at the same time [default: one per core].
    #[arg(long)]
    pub(crate) threads: Option<usize>,
    /// Skip the comparison of all filters, which flies separate missions.
    #[arg(long)]
    pub(crate) paper_only: bool,
}

/// Runs the experiment; an error if a run fails or a goal of G1 is clearly missed.
pub(crate) fn run(options: &Options) -> anyhow::Result<()> {
    let threads = options.threads.unwrap_or_else(default_threads);
    let folder = paths::target().join("reproduce");
    let results = folder.join("campaign");
    let campaign = Campaign::run(options.seeds, threads, &folder.join("runs"), &results)?;
    let verdicts = verdicts(&campaign);
    print(&campaign, &verdicts);

    let figures = Figures::of(&campaign)?;
    figures.write(&folder.join("figures"))?;
    let report = folder.join("report.html");
    let mut page = page::page(&campaign, &verdicts, &figures, options.seeds)?;
    // After the comparison of the paper's filters, before the figures.
    if !options.paper_only {
        page.sections.insert(5, comparison::section(options.seeds, threads)?);
    }
    let html = campaign::page(&results, &page)?;
    std::fs::write(&report, html).with_context(|| format!("cannot write {}", report.display()))?;
    println!("Report: {}", report.display());
    conclude(&campaign, &verdicts)
}

/// Fails if the picture of the README is not the figure that the last run wrote; it is the same for
/// any number of seeds.
pub(crate) fn check_picture() -> anyhow::Result<()> {
    let (picture, figure) = ("examples/be3.svg", "reproduce/figures/path-BE3.svg");
    let read =
        |file: std::path::PathBuf| std::fs::read(&file).with_context(|| file.display().to_string());
    if read(paths::root().join(picture))? != read(paths::target().join(figure))? {
        bail!("{picture} is not what `cargo xtask reproduce` draws: copy target/{figure} there");
    }
    Ok(())
}

/// The tables and verdicts as text.
fn print(campaign: &Campaign, verdicts: &[Verdict]) {
    for course in Course::ALL {
        println!("{}", tables::of_course(campaign, course).text());
    }
    println!("{}", tables::equal_fix(campaign).text());
    for line in page::DIFFERENCES {
        println!("{line}\n");
    }
    println!("{}", tables::goals(verdicts).text());
}

/// An error that names the missed goals and the runs that did not arrive.
fn conclude(campaign: &Campaign, verdicts: &[Verdict]) -> anyhow::Result<()> {
    let missed = verdicts.iter().filter(|v| v.is_missed());
    let missed: Vec<String> =
        missed.map(|v| format!("{} is {}, goal {}", v.what, v.value(), v.bounds())).collect();
    let lost: Vec<String> =
        campaign.unfinished().map(|case| format!("not finished: {case}")).collect();
    if missed.is_empty() && lost.is_empty() {
        match verdicts.iter().filter(|v| !v.is_reached()).count() {
            0 => println!("G1 reached; every run finished its course."),
            open => println!("{open} goals open for want of seeds; every run finished."),
        }
        return Ok(());
    }
    bail!("goal G1 is missed:\n  {}", [missed, lost].concat().join("\n  "))
}
