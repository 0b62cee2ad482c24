//! The report of a results file: a page, or one figure as a picture.

use std::collections::BTreeMap;

use super::convert;
use super::figure::{Figure, Panel, Series};
use super::run::{Choice, Shown, Trace};
use super::{Document, Plot, Role, Term, Units, XyPlot, run_terms};
use crate::scenario::Scenario;
use crate::{Code, Error, Recording, Result};

const PANEL_HEIGHT: f64 = 130.0;

/// Maximum size of a run on its page, in octets.
const OCTETS: usize = 4_500_000;

/// Options of the report of a results file.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Title of the page.
    pub title: String,
    /// Signals to draw over time, before all others.
    pub plots: Vec<Plot>,
    /// Signals to draw against each other.
    pub paths: Vec<XyPlot>,
    /// Units of the signals.
    pub units: Units,
    /// The truth and its estimates.
    pub choice: Choice,
    /// The scenario that was used: its faults are shaded.
    pub scenario: Option<Scenario>,
    /// Provenance of the results: names and values.
    pub sources: Vec<(String, String)>,
}

/// The report of a results file as one HTML page.
pub fn html(recording: &Recording, options: &Options) -> Result<String> {
    let shown = Shown {
        units: options.units.clone().or_of(recording),
        choice: options.choice.clone(),
        faults: options.scenario.iter().flat_map(|s| s.windows(recording)).collect(),
        plots: &options.plots,
        paths: &options.paths,
        all: true,
        ..Shown::default()
    };
    let trace = Trace::within(recording, shown, OCTETS)?;
    let mut provenance: Vec<Term> =
        options.sources.iter().map(|(name, value)| Term::new(name, value)).collect();
    provenance.push(Term::new("Reported by", concat!("cosim ", env!("CARGO_PKG_VERSION"))));
    let document = Document::<()> {
        title: options.title.clone(),
        question: String::new(),
        summary: Vec::new(),
        sections: Vec::new(),
        notes: trace.notes.clone(),
        method: run_terms(),
        provenance,
        identity: Vec::new(),
        campaign: None,
        runs: BTreeMap::from([(String::new(), trace)]),
    };
    document.html()
}

/// File formats of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Picture {
    /// Scalable Vector Graphics.
    Svg,
    /// Pixels.
    Png,
    /// A page of the figure's size.
    Pdf,
}

/// The single requested figure, as a file.
pub fn picture(recording: &Recording, options: &Options, format: Picture) -> Result<Vec<u8>> {
    let svg = svg(recording, options)?;
    match format {
        Picture::Svg => Ok(svg.into_bytes()),
        Picture::Png => convert::png(&svg),
        Picture::Pdf => convert::pdf(&svg),
    }
}

fn svg(recording: &Recording, options: &Options) -> Result<String> {
    let units = options.units.clone().or_of(recording);
    match (options.paths.as_slice(), options.plots.as_slice()) {
        ([path], []) => path_figure(recording, path, &units)?.svg(),
        ([], [plot]) => time_figure(recording, plot, &units)?.svg(),
        _ => Err(Error::new(Code::Usage, "a picture holds one figure")
            .help("choose one --plot or one --xy, or write a page: a name that ends in .html")),
    }
}

fn over_time(recording: &Recording, values: &[f64]) -> Vec<(f64, f64)> {
    recording.time().iter().copied().zip(values.iter().copied()).collect()
}

/// One panel for each unit.
fn time_figure(recording: &Recording, plot: &Plot, units: &Units) -> Result<Figure> {
    let mut panels: Vec<(&str, Vec<Series>)> = Vec::new();
    for (place, name) in plot.signals.iter().enumerate() {
        let points = over_time(recording, recording.column(name)?);
        let series = Series::line(name, Role::Signal(place), points);
        let unit = units.unit(name).unwrap_or_default();
        match panels.iter_mut().find(|(known, _)| *known == unit) {
            Some((_, panel)) => panel.push(series),
            None => panels.push((unit, vec![series])),
        }
    }
    let panel = |(unit, series)| Panel::new("time (s)", unit, 2.0 * PANEL_HEIGHT, series);
    Ok(Figure::stacked(plot.title.as_str(), panels.into_iter().map(panel).collect()))
}

fn path_figure(recording: &Recording, plot: &XyPlot, units: &Units) -> Result<Figure> {
    let line = |(i, (x, y)): (usize, &(String, String))| {
        let (x_values, y_values) = (recording.column(x)?, recording.column(y)?);
        let points = x_values.iter().copied().zip(y_values.iter().copied()).collect();
        Ok::<_, Error>(Series::line(&format!("{x}, {y}"), Role::Signal(i), points))
    };
    let series = plot.pairs.iter().enumerate().map(line).collect::<Result<_, _>>()?;
    let (x, y) = plot.pairs.first().map(|(x, y)| (x.as_str(), y.as_str())).unwrap_or_default();
    let named = |name| units.labelled(name);
    let panel = Panel::new(&named(x), &named(y), 480.0, series);
    Ok(Figure::paths(plot.title.as_str(), 1, vec![panel]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Recording {
        let names =
            ["a.pose.x", "a.pose.y", "a.pose.yaw", "b.depth", "alone"].map(String::from).to_vec();
        let columns = [60.0, 30.0, 0.5, f64::NAN, 1.0].map(|last| vec![0.0, last]).to_vec();
        Recording::from_columns(names, vec![0.0, 1.0], columns)
    }

    #[test]
    fn every_signal_is_there_and_selections_come_first() {
        let page = html(&sample(), &Options::default()).unwrap();
        for name in sample().names() {
            assert!(page.contains(&format!("\"name\":\"{name}\"")), "{name}");
        }
        let plots = vec!["Heading: a.pose.yaw".parse().unwrap()];
        let paths = vec!["Path: a.pose.x, a.pose.y".parse().unwrap()];
        let page = html(&sample(), &Options { plots, paths, ..Options::default() }).unwrap();
        assert!(page.contains("\"plots\":[{\"section\":\"Selected\",\"title\":\"Heading\""));
        assert!(page.contains("\"x\":\"a.pose.x (m)\""));
        let plots = vec!["Heading: a.pose.yow".parse().unwrap()];
        let error = html(&sample(), &Options { plots, ..Options::default() }).unwrap_err();
        assert!(error.to_string().contains("a.pose.yaw"));
    }

    #[test]
    fn a_picture_is_one_figure() {
        let paths = vec!["Path: a.pose.x, a.pose.y".parse().unwrap()];
        let one = Options { paths, ..Options::default() };
        assert!(svg(&sample(), &one).unwrap().starts_with("<svg"));
        let error = svg(&sample(), &Options::default()).unwrap_err().to_string();
        assert!(error.contains("one --plot or one --xy"), "{error}");
    }

    #[test]
    fn a_picture_has_a_panel_and_a_label_for_each_unit() {
        let plots = vec!["Pose: a.pose.x, a.pose.yaw, a.pose.y".parse().unwrap()];
        let picture = svg(&sample(), &Options { plots, ..Options::default() }).unwrap();
        let labels = |of: &str| picture.lines().filter(|line| line.trim() == of).count();
        assert_eq!((labels("m"), labels("rad")), (1, 1), "{picture}");
    }
}
