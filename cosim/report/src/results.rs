//! The report of a results file: a page, or one figure as a picture.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::figure::{Figure, Panel, Series};
use super::run::{Choice, Shown, Trace};
use super::{Document, Plot, Role, Term, Units, XyPlot, convert, declared, run_terms};
use cosim_base::sha256;
use cosim_core::scenario::Scenario;
use cosim_core::{Code, Error, Recording, Result};
use cosim_results::roles::Declaration;

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
    /// A file that declares them, instead.
    pub roles: Option<Declaration>,
    /// The scenario that was used: its faults are shaded.
    pub scenario: Option<Scenario>,
    /// Provenance of the results: names and files.
    pub sources: Vec<(String, PathBuf)>,
}

/// The report of a results file as one HTML page.
pub fn html(recording: &Recording, options: &Options) -> Result<String> {
    let declared = match &options.roles {
        Some(roles) => Some(declared::declared(recording, roles)?),
        None => None,
    };
    let (recording, choice) = match &declared {
        Some((recording, choice)) => (recording, choice),
        None => (recording, &options.choice),
    };
    // Declared columns have been converted: their units are those of the recording.
    let known =
        if declared.is_some() { Units::default().or_of(recording) } else { Units::default() };
    let shown = Shown {
        units: known.or(options.units.clone()).or_of(recording),
        choice: choice.clone(),
        faults: options.scenario.iter().flat_map(|s| s.windows(recording)).collect(),
        plots: &options.plots,
        paths: &options.paths,
        all: true,
        ..Shown::default()
    };
    let trace = Trace::within(recording, shown, OCTETS)?;
    let mut provenance: Vec<Term> =
        options.sources.iter().map(|(name, file)| Term::new(name, with_hash(file))).collect();
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

/// A file with its hash; a folder has none.
fn with_hash(file: &Path) -> String {
    let name = file.display();
    std::fs::read(file)
        .map_or_else(|_| name.to_string(), |text| format!("{name}, SHA-256 {}", sha256(text)))
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

/// One panel for each unit, and for each variable whose unit is not known.
fn time_figure(recording: &Recording, plot: &Plot, units: &Units) -> Result<Figure> {
    let mut panels: Vec<(&str, Vec<Series>)> = Vec::new();
    for (place, name) in plot.signals.iter().enumerate() {
        let points = over_time(recording, recording.column(name)?);
        let series = Series::line(name, Role::Signal(place), points);
        match panels.iter_mut().find(|(first, _)| units.axis(first) == units.axis(name)) {
            Some((_, panel)) => panel.push(series),
            None => panels.push((name, vec![series])),
        }
    }
    let panel = |(name, series)| {
        let unit = units.unit(name).unwrap_or_default();
        Panel::new("time (s)", unit, 2.0 * PANEL_HEIGHT, series)
    };
    Ok(Figure::stacked(plot.title.as_str(), panels.into_iter().map(panel).collect()))
}

fn path_figure(recording: &Recording, plot: &XyPlot, units: &Units) -> Result<Figure> {
    let mut number = 0..;
    let mut line = |(x, y): &(String, String)| {
        let (x_values, y_values) = (recording.column(x)?, recording.column(y)?);
        let points = x_values.iter().copied().zip(y_values.iter().copied()).collect();
        let role = Role::Signal(number.next().unwrap_or_default());
        Ok::<_, Error>(Series::line(&format!("{x}, {y}"), role, points))
    };
    let mut panel = |pairs: Vec<&(String, String)>| {
        let (x, y) = pairs[0];
        let series = pairs.iter().map(|pair| line(pair)).collect::<Result<_, _>>()?;
        Ok::<_, Error>(Panel::new(&units.labelled(x), &units.labelled(y), 480.0, series))
    };
    let panels = plot.by_unit(units).into_iter().map(&mut panel).collect::<Result<_, _>>()?;
    Ok(Figure::paths(plot.title.as_str(), 1, panels))
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

    #[test]
    fn pairs_with_other_units_have_their_own_axes() {
        let plot =
            |text: &str| Options { paths: vec![text.parse().unwrap()], ..Options::default() };
        let pairs = plot("P: a.pose.x, a.pose.y; a.pose.yaw, a.pose.y; a.pose.y, a.pose.x");
        let page = html(&sample(), &pairs).unwrap();
        for axes in ["\"x\":\"a.pose.x (m)\",\"y\":\"a.pose.y (m)\"", "\"x\":\"a.pose.yaw (rad)\""]
        {
            assert_eq!(page.matches(axes).count(), 1, "{axes}");
        }
        assert!(!page.contains("\"x\":\"a.pose.y (m)\""));
        assert!(svg(&sample(), &pairs).unwrap().contains("a.pose.yaw (rad)"));
        // Their units are not known.
        let names = ["one", "two", "many[0]", "many[1]"].map(String::from).to_vec();
        let four = Recording::from_columns(names, vec![0.0, 1.0], vec![vec![0.0, 1.0]; 4]);
        let plots = vec!["All: one, two, many[0], many[1]".parse().unwrap()];
        let page = html(&four, &Options { plots, ..Options::default() }).unwrap();
        assert_eq!(page.matches("\"section\":\"Selected\"").count(), 3);
        let page = html(&four, &plot("P: one, one; two, one; many[0], one; many[1], one")).unwrap();
        assert_eq!(page.matches("\"title\":\"P\"").count(), 3);
    }

    #[test]
    fn headings_in_degrees_turn_after_360() {
        let names = "t.pose.x t.pose.y t.pose.yaw e.pose.x e.pose.y e.pose.yaw e.sigma.x e.sigma.y \
            e.sigma.yaw";
        let names: Vec<String> = names.split_whitespace().map(str::to_owned).collect();
        let angles = [("t.pose.yaw", "rad", 3.0_f64), ("e.pose.yaw", "deg", -179.0)];
        let column = |name: &String| {
            let angle = angles.iter().find(|(known, ..)| known == name);
            vec![angle.map_or(1.0, |(_, _, value)| *value); 2]
        };
        let unit = |name: &String| {
            let angle = angles.iter().find(|(known, ..)| known == name);
            angle.map_or(if name.ends_with("yaw") { "rad" } else { "m" }, |(_, unit, _)| *unit)
        };
        let (columns, units) = (names.iter().map(column).collect(), names.iter().map(unit));
        let units = units.map(str::to_owned).collect();
        let recording = Recording::from_columns(names, vec![0.0, 1.0], columns).with_units(units);
        let page = html(&recording, &Options::default()).unwrap();
        let error = page.split("\"title\":\"e.pose.yaw: error\"").nth(1).unwrap();
        // -179 degrees and 3 rad (171.887 degrees): 9.1127 degrees. 3 sigma: 171.89 degrees.
        assert!(error.starts_with(",\"unit\":\"deg\""), "{}", &error[..300]);
        assert!(error[..300].contains("\"v\":[9.1127,9.1127]"), "{}", &error[..300]);
        assert!(error[..400].contains("[171.89,171.89]"), "{}", &error[..400]);
        let heading = page.split("\"title\":\"yaw, clockwise from north\"").nth(1).unwrap();
        assert!(heading.starts_with(",\"unit\":\"deg\""), "{}", &heading[..300]);
        assert!(heading[..300].contains("\"v\":[171.89,171.89]"), "{}", &heading[..300]);
        assert!(heading[..300].contains("\"v\":[-179,-179]"), "{}", &heading[..300]);
        // The map turns its arrows by radians.
        assert!(page.contains("\"yaw\":[-3.1241,-3.1241]"));
    }

    #[test]
    fn the_course_is_on_the_map_beside_truth_and_estimate() {
        let groups = ["guide.reference", "t.pose", "e.pose", "e.sigma", "fix.position"];
        let axes = groups.iter().flat_map(|group| ["x", "y"].map(|axis| format!("{group}.{axis}")));
        let names: Vec<String> = axes.collect();
        let columns = (0..names.len()).map(|column| vec![column as f64, 50.0]).collect();
        let recording = Recording::from_columns(names, vec![0.0, 1.0], columns);
        let page = html(&recording, &Options::default()).unwrap();
        let map = page.split("\"map\":").nth(1).unwrap().split("\"plots\":").next().unwrap();
        for (name, role, x) in [
            ("guide.reference", "course", 0),
            ("t.pose", "truth", 2),
            ("e.pose", "estimate", 4),
            ("fix.position", "fix", 50),
        ] {
            let path = format!("{{\"name\":\"{name}\",\"role\":\"{role}\",\"x\":[{x}");
            assert_eq!(map.matches(&path).count(), 1, "{path}: {map}");
        }
        assert_eq!(map.matches("\"role\"").count(), 4);
    }

    #[test]
    fn plots_that_do_not_fit_are_counted() {
        let names: Vec<String> =
            (0..40_000).map(|i| format!("p{}.status[{}]", i / 9, i % 9)).collect();
        let columns = (0..40_000).map(|i| vec![f64::from(i); 2]).collect();
        let recording = Recording::from_columns(names, vec![0.0, 1.0], columns);
        let page = html(&recording, &Options::default()).unwrap();
        assert!(page.len() < 5_000_000, "{}", page.len());
        assert!(page.contains("plots do not fit on this page"));
    }
}
