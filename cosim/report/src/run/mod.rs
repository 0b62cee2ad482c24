//! One run as data for the page: the map first, then plots on the estimates, the actuators and
//! health, followed by everything that was recorded.

mod columns;
mod map;
mod navigation;
mod plots;
mod signals;
mod thin;

use serde::Serialize;

use self::columns::Columns;
use self::map::Map;
use self::plots::{Plot, Role, Whole};
use super::units::Units;
use super::{Plot as Chosen, XyPlot};
use cosim_core::scenario::Window;
use cosim_core::{Recording, Result};
use cosim_results::roles::{Names, Paths};

pub use self::navigation::freedom;
pub use cosim_results::roles::{Choice, Estimate};

/// How to show a run.
#[derive(Debug, Default)]
pub struct Shown<'a> {
    /// The units of the variables.
    pub units: Units,
    /// Which paths are shown.
    pub choice: Choice,
    /// Time spans shaded on every time axis.
    pub faults: Vec<Window>,
    /// Requested plots come first.
    pub plots: &'a [Chosen],
    /// Further paths in the plane.
    pub paths: &'a [XyPlot],
    /// Whether all variables are included after the rest.
    pub all: bool,
    /// Approximate maximum number of values of the run.
    pub numbers: usize,
}

/// A run as data of the page.
#[derive(Debug, Clone, Serialize)]
pub struct Trace {
    start: f64,
    stop: f64,
    instants: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    map: Option<Map>,
    xy: Vec<Plane>,
    plots: Vec<Plot>,
    signals: Vec<Plot>,
    table: Vec<signals::Row>,
    faults: Vec<Window>,
    pub(crate) notes: Vec<String>,
}

/// A list of a plot has at least this many values, or the plot is left out.
const LEAST: usize = 20;

/// Curves of pairs of variables, at equal scale.
#[derive(Debug, Clone, Serialize)]
struct Plane {
    title: String,
    x: String,
    y: String,
    lines: Vec<Curve>,
}

#[derive(Debug, Clone, Serialize)]
struct Curve {
    name: String,
    x: super::numbers::Numbers,
    y: super::numbers::Numbers,
}

impl Trace {
    /// Approximate maximum size as JSON, in octets.
    pub fn within(recording: &Recording, mut shown: Shown<'_>, octets: usize) -> Result<Self> {
        shown.numbers = octets / 7;
        let mut trace = Self::new(recording, &shown)?;
        // The number of digits varies.
        for _ in 0..6 {
            let size = serde_json::to_vec(&trace).map_or(0, |octets| octets.len());
            if size <= octets {
                break;
            }
            shown.numbers = shown.numbers * octets / size * 9 / 10;
            trace = Self::new(recording, &shown)?;
        }
        Ok(trace)
    }

    /// From a recording; an error if a requested variable is missing.
    fn new(recording: &Recording, shown: &Shown<'_>) -> Result<Self> {
        let columns = Columns::of(recording);
        let paths = Paths::find(&Names::new(columns.names.iter().copied()), &shown.choice)?;
        let mut notes = columns.notes.clone();
        if paths.truth.is_none() {
            notes.push(
                "no truth is recorded (a group called pose with x and y): errors are not shown"
                    .to_owned(),
            );
        } else if paths.estimates.is_empty() {
            notes.push("no estimate is recorded: errors are not shown".to_owned());
        }
        let mut first = chosen(recording, &columns, shown)?;
        first.extend(depth(&columns, &paths, &shown.units));
        first.push(navigation::headings(&columns, &paths, &shown.units));
        first.extend(navigation::errors(&columns, &paths, &shown.units));
        first.extend(navigation::consistency(&columns, &paths));
        first.extend(navigation::normalized(&columns, &paths));
        first.extend(navigation::innovations(&columns, &paths, &shown.units));
        first.extend(signals::system(&columns, &shown.units));
        first.retain(|plot| !plot.is_empty());
        let (mut behind, mut table) = (Vec::new(), Vec::new());
        if shown.all {
            let (plots, left_out) = signals::plots(&columns, &shown.units);
            let (rows, cut) = signals::table(&columns, &shown.units);
            notes.extend(left_out.into_iter().chain(cut));
            (behind, table) = (plots, rows);
        }
        // The map gets a fifth of all values, the sections at the front at least half of the rest.
        let instants = (shown.numbers / 50).clamp(40, 1500);
        let map = Map::of(&columns, &paths, &shown.units, instants);
        let of_all = shown.numbers * 4 / 5;
        let in_front = if behind.is_empty() { of_all } else { of_all / 2 };
        let count = first.len();
        let mut lists = 0;
        first.retain(|plot| {
            lists += plot.lists();
            lists * LEAST <= in_front
        });
        if first.len() < count {
            let left = count - first.len();
            notes.push(format!("{left} plots do not fit on this page: name others with --plot"));
        }
        let thin = |plots: Vec<Whole>, numbers: usize| -> Vec<Plot> {
            let lists: usize = plots.iter().map(Whole::lists).sum();
            let share = |plot: &Whole| numbers * plot.lists() / lists;
            let thinned = plots.into_iter().map(|plot| {
                let share = share(&plot);
                plot.thinned(&columns, share)
            });
            thinned.collect()
        };
        Ok(Self {
            start: columns.time.first().copied().unwrap_or(0.0),
            stop: columns.time.last().copied().unwrap_or(0.0),
            instants: columns.time.len(),
            xy: planes(recording, shown)?,
            map,
            plots: thin(first, in_front),
            signals: thin(behind, of_all / 2),
            table,
            faults: shown.faults.clone(),
            notes,
        })
    }
}

/// The requested plots; variables with a different unit, or an unknown one, get a separate one.
fn chosen(recording: &Recording, columns: &Columns<'_>, shown: &Shown<'_>) -> Result<Vec<Whole>> {
    let mut plots: Vec<Whole> = Vec::new();
    for plot in shown.plots {
        let first = plots.len();
        for name in &plot.signals {
            let Some(values) = columns.get(name) else {
                // It is text, or unknown.
                recording.column(name)?;
                continue;
            };
            let axis = |name: &str| shown.units.axis(name);
            let line = (name.clone(), Role::Signal, values);
            match plots[first..].iter_mut().find(|whole| axis(&whole.lines[0].0) == axis(name)) {
                Some(whole) => whole.lines.push(line),
                None => plots.push(Whole {
                    section: "Selected".into(),
                    title: plot.title.clone(),
                    unit: shown.units.unit(name).unwrap_or_default().into(),
                    lines: vec![line],
                    ..Whole::default()
                }),
            }
        }
    }
    Ok(plots)
}

/// The truth, then the estimates, then the courses.
fn paths_of(paths: &Paths) -> impl Iterator<Item = (&str, Role)> {
    let truth = paths.truth.iter().map(|path| (path.as_str(), Role::Truth));
    let estimates = paths.estimates.iter().map(|estimate| (estimate.path.as_str(), Role::Estimate));
    let courses = paths.courses.iter().map(|path| (path.as_str(), Role::Course));
    truth.chain(estimates).chain(courses)
}

/// Depths, if any of them changes.
fn depth(columns: &Columns<'_>, paths: &Paths, units: &Units) -> Option<Whole> {
    let lines = paths_of(paths).filter_map(|(path, role)| {
        let name = format!("{path}.z");
        Some((name.clone(), role, columns.get(&name)?))
    });
    let lines: Vec<_> = lines.collect();
    let varies = |values: &[f64]| {
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let (least, most) = (finite().reduce(f64::min), finite().reduce(f64::max));
        least.zip(most).is_some_and(|(least, most)| most - least > 1e-6)
    };
    let unit = units.unit(&lines.first()?.0).unwrap_or_default().to_owned();
    lines.iter().any(|(_, _, values)| varies(values)).then(|| Whole {
        section: "Depth and heading".into(),
        title: "z, down".into(),
        unit,
        lines,
        down: true,
        ..Whole::default()
    })
}

fn planes(recording: &Recording, shown: &Shown<'_>) -> Result<Vec<Plane>> {
    let named = |name: &str| shown.units.labelled(name);
    let plane = |(plot, pairs): (&XyPlot, Vec<&(String, String)>)| {
        let curve = |(x, y): &(String, String)| {
            let (x_values, y_values) = (recording.column(x)?, recording.column(y)?);
            let places = thin::even(x_values.len(), 2000);
            let pick = |of: &[f64]| super::numbers::Numbers::values(places.iter().map(|&p| of[p]));
            Ok(Curve { name: format!("{x}, {y}"), x: pick(x_values), y: pick(y_values) })
        };
        let (x, y) = pairs[0];
        Ok(Plane {
            title: plot.title.clone(),
            x: named(x),
            y: named(y),
            lines: pairs.into_iter().map(curve).collect::<Result<_>>()?,
        })
    };
    let by_unit = |plot| XyPlot::by_unit(plot, &shown.units).into_iter().map(move |of| (plot, of));
    shown.paths.iter().flat_map(by_unit).map(plane).collect()
}
