//! `cosim report`: results as a page or a picture.

use std::path::{Path, PathBuf};

use clap::Args;
use cosim::campaign;
use cosim::report::{Choice, Estimate, Options, Picture, Plot, Units, XyPlot, html, picture};
use cosim::roles::Declaration;
use cosim::scenario::Scenario;
use cosim::{Code, Error, Overrides, Result, System, files, names};
use indicatif::{ProgressBar, ProgressStyle};

use super::output::print;
use super::{interrupt, messages};

/// Make a self-contained HTML page of a campaign or of recorded results, or a single picture
#[derive(Args)]
pub(crate) struct Report {
    /// The folder of a campaign, or the results of one run: CSV with the time in its first column,
    /// or MCAP written by this program
    results: PathBuf,
    /// Output file for the page, or for the figure if the name ends in .svg, .png or .pdf; - for stdout (default:
    /// name of the results with .html; for a campaign, report.html in its folder)
    #[arg(long, short, value_name = "FILE")]
    output_file: Option<PathBuf>,
    /// Title of the page (default: name of the results)
    #[arg(long)]
    title: Option<String>,
    /// Repeat this many runs of each cell and show them in full: the worst, the median, and others
    /// in between; 0 for none
    #[arg(long, value_name = "N", default_value_t = 2)]
    runs_per_cell: usize,
    /// Plot these columns over time, before all others (repeatable)
    #[arg(long, value_name = "TITLE: COLUMN, ...")]
    plot: Vec<Plot>,
    /// Plot columns against each other (repeatable)
    #[arg(long, value_name = "TITLE: X, Y; ...")]
    xy: Vec<XyPlot>,
    /// The system that was run: for the units of the columns
    #[arg(long, value_name = "FILE")]
    system: Option<PathBuf>,
    /// The scenario that was used: its faults are shaded
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// The true path, as vehicle.pose (default: the first pose without standard deviations)
    #[arg(long, value_name = "NAME")]
    truth: Option<String>,
    /// An estimated path, as filter.pose (repeatable; default: those with standard deviations)
    #[arg(long, value_name = "NAME")]
    estimate: Vec<String>,
    /// A file that assigns variables to the truth, its estimates and sensors, with their axes
    /// (default: by the names of the variables)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["truth", "estimate"])]
    roles: Option<PathBuf>,
}

/// What a file with this extension is.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Page,
    Picture(Picture),
}

impl Report {
    pub(crate) fn run(self) -> Result<()> {
        let is_campaign = self.results.is_dir();
        let target = self.output_file.clone().unwrap_or_else(|| match is_campaign {
            true => self.results.join("report.html"),
            false => self.results.with_extension("html"),
        });
        let kind = kind(&target)?;
        let page = match (is_campaign, kind) {
            (true, Kind::Page) => self.campaign()?.into_bytes(),
            (true, Kind::Picture(_)) => {
                return Err(Error::new(Code::Usage, "a picture holds one figure of one run")
                    .at(&target)
                    .help("repeat a run of the campaign (cosim replay), and report its results"));
            }
            (false, _) => self.single(kind)?,
        };
        if target.as_os_str() == "-" {
            return print(&String::from_utf8_lossy(&page));
        }
        files::refuse_inputs(&target, [])?;
        files::replace(&target, &page).map_err(|e| {
            Error::new(Code::Output, "the page cannot be written").at(&target).why(e)
        })?;
        if is_campaign && interrupt::interrupted() {
            return Err(Error::new(Code::Interrupted, "the report was interrupted")
                .why(format!("some runs are not shown in {}", target.display()))
                .help("run the same command again"));
        }
        messages::info(&format!("the report is in {}", target.display()));
        Ok(())
    }

    fn single(&self, kind: Kind) -> Result<Vec<u8>> {
        let recording = cosim::observe::read_unfinished(&self.results)?;
        let stem = || self.results.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let estimate = |path: &String| Estimate { path: path.clone(), ..Estimate::default() };
        let mut sources = vec![("Results".to_owned(), self.results.clone())];
        let mut source = |name: &str, file: &Option<PathBuf>| {
            sources.extend(file.iter().map(|f| (name.to_owned(), f.clone())));
        };
        source("System", &self.system);
        source("Scenario", &self.scenario);
        source("Roles", &self.roles);
        let options = Options {
            title: self.title.clone().unwrap_or_else(stem),
            plots: self.plot.clone(),
            paths: self.xy.clone(),
            units: self.system.as_deref().map_or(Ok(Units::default()), units)?,
            choice: Choice {
                truth: self.truth.clone(),
                estimates: self.estimate.iter().map(estimate).collect(),
                ..Choice::default()
            },
            roles: self.roles.as_ref().map(Declaration::read).transpose()?,
            scenario: self.scenario.as_ref().map(Scenario::read).transpose()?,
            sources,
        };
        recording.missing().iter().for_each(|note| messages::note(note));
        match kind {
            Kind::Page => html(&recording, &options).map(String::into_bytes),
            Kind::Picture(format) => picture(&recording, &options, format),
        }
    }

    fn campaign(&self) -> Result<String> {
        let given = [
            ("--plot", !self.plot.is_empty()),
            ("--xy", !self.xy.is_empty()),
            ("--system", self.system.is_some()),
            ("--scenario", self.scenario.is_some()),
            ("--truth", self.truth.is_some()),
            ("--estimate", !self.estimate.is_empty()),
            ("--roles", self.roles.is_some()),
        ];
        if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
            let what = format!("{option} applies to the results of one run, but a folder is given");
            return Err(Error::new(Code::Usage, what).at(&self.results));
        }
        interrupt::watch();
        let style =
            ProgressStyle::with_template("{wide_bar} {pos}/{len} runs repeated, {eta} left");
        let bar = style.map_or_else(
            |_| ProgressBar::no_length(),
            |style| ProgressBar::no_length().with_style(style),
        );
        let mut more = |left: usize| {
            if bar.length().is_none() {
                bar.set_length(left as u64);
            }
            bar.set_position(bar.length().unwrap_or(0) - left as u64);
            !interrupt::interrupted()
        };
        let options = campaign::Report {
            title: self.title.clone(),
            runs_per_cell: self.runs_per_cell,
            ..campaign::Report::default()
        };
        let outcome = campaign::report(&self.results, &options, &mut more);
        bar.finish_and_clear();
        let (page, notes) = outcome?;
        notes.iter().for_each(|note| messages::note(note));
        Ok(page)
    }
}

/// Units of everything that a system can record.
fn units(file: &Path) -> Result<Units> {
    let all = Overrides::new().output_variables(["*"]);
    System::load(file, &all).map(|system| Units::of(&system))
}

/// By the extension of the name; an unknown one is refused.
fn kind(target: &Path) -> Result<Kind> {
    const KNOWN: [&str; 5] = ["html", "htm", "svg", "png", "pdf"];
    let Some(ending) = target.extension() else { return Ok(Kind::Page) };
    let ending = ending.to_string_lossy().to_ascii_lowercase();
    Ok(match ending.as_str() {
        "html" | "htm" => Kind::Page,
        "svg" => Kind::Picture(Picture::Svg),
        "png" => Kind::Picture(Picture::Png),
        "pdf" => Kind::Picture(Picture::Pdf),
        other => {
            let what = format!("a report cannot be written as .{other}");
            return Err(Error::new(Code::Usage, what)
                .at(target)
                .why("known extensions are .html (a page), and .svg, .png and .pdf (one figure)")
                .maybe_help(names::did_you_mean(other, KNOWN)));
        }
    })
}
