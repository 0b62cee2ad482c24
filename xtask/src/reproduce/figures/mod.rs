//! The figures of the report, each also as a separate file.

mod acceleration;
mod errors;
mod paths;
mod spread;
mod thrust;

use std::path::Path;

use anyhow::Context;
use cosim::report::{Block, Figure, Role};

use super::campaign::{Campaign, SHOWN_SEED};
use super::case::{Case, Course, Filter};
use super::trace::Trace;

/// A figure with its file name and its caption.
pub(crate) struct Captioned {
    pub(crate) name: String,
    pub(crate) figure: Figure,
    pub(crate) caption: String,
}

/// The figures, by section of the report.
pub(crate) struct Figures {
    /// Paths, figures 6 to 8 of the paper.
    pub(crate) paths: Vec<Captioned>,
    /// Surge acceleration, figure 4 of the paper.
    pub(crate) acceleration: Captioned,
    /// Estimation errors with their standard deviations.
    pub(crate) errors: Captioned,
    /// Thrust.
    pub(crate) thrust: Captioned,
    /// Distribution over seeds.
    pub(crate) spread: Captioned,
}

impl Figures {
    /// Plans all figures.
    pub(crate) fn of(campaign: &Campaign) -> anyhow::Result<Self> {
        let paths = Course::ALL.into_iter().map(|course| paths::figure(campaign, course));
        Ok(Figures {
            paths: paths.collect::<anyhow::Result<_>>()?,
            acceleration: acceleration::figure(campaign)?,
            errors: errors::figure(campaign)?,
            thrust: thrust::figure(campaign)?,
            spread: spread::figure(campaign),
        })
    }

    /// Writes every figure as an SVG file into a folder.
    pub(crate) fn write(&self, folder: &Path) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        let single = [&self.acceleration, &self.errors, &self.thrust, &self.spread];
        for figure in self.paths.iter().chain(single) {
            let file = folder.join(format!("{}.svg", figure.name));
            std::fs::write(&file, figure.figure.svg()?)
                .with_context(|| format!("cannot write {}", file.display()))?;
        }
        Ok(())
    }
}

impl Captioned {
    /// The figure as a part of a page.
    pub(crate) fn block(&self) -> anyhow::Result<Block> {
        Ok(Block::figure(&self.figure, self.caption.as_str())?)
    }
}

/// The look of a filter, the same in every figure.
fn role(filter: Filter) -> Role {
    match filter {
        Filter::Dynamic => Role::Estimate1,
        Filter::Kinematic => Role::Estimate2,
    }
}

/// The signals of the run that the figures show.
fn shown(campaign: &Campaign, course: Course, filter: Filter) -> anyhow::Result<&Trace> {
    campaign.trace(|c: &Case| {
        c.is_in_paper() && (c.course, c.filter, c.seed) == (course, filter, SHOWN_SEED)
    })
}

/// Values over time as points.
fn over_time(trace: &Trace, values: &[f64]) -> Vec<(f64, f64)> {
    trace.time.iter().copied().zip(values.iter().copied()).collect()
}
