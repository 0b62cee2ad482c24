//! The generic report of a result file: one figure a component with a panel for each group of
//! signals, after the figures that were asked for, and a table of ranges.
//!
//! `vehicle.pose.x` belongs to component `vehicle`, group `pose`; `plant.thruster[3].thrust` to
//! group `thruster[].thrust`. Within a group, signals of like size share a panel.

use super::figure::{Figure, LegendPlace, Panel, Series};
use super::style::DISTINCT_SIGNALS;
use super::{Block, Page, Plot, Results, Role, Section, Table, XyPlot, mean};
use crate::{Error, Result};

/// Signals of one group share a panel while their sizes differ by less than this factor.
const LIKE_SIZE: f64 = 20.0;
const PANEL_HEIGHT: f64 = 130.0;

/// What the report of a result file shows.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Title of the page.
    pub title: String,
    /// Signals to draw over time. Without these and `paths`, every signal is drawn.
    pub plots: Vec<Plot>,
    /// Signals to draw against each other.
    pub paths: Vec<XyPlot>,
}

/// The report of a result file as one HTML page.
pub fn html(results: &Results, options: &Options) -> Result<String> {
    let mut chosen = Section::new("Selected signals");
    for plot in &options.paths {
        chosen.blocks.push(Block::figure(
            &path_figure(results, plot)?,
            plot.title.as_str(),
        )?);
    }
    for plot in &options.plots {
        chosen.blocks.push(Block::figure(
            &time_figure(results, plot)?,
            plot.title.as_str(),
        )?);
    }
    let mut sections = Vec::new();
    if chosen.blocks.is_empty() {
        for component in components(results) {
            let name = if component.name.is_empty() {
                "Signals"
            } else {
                &component.name
            };
            let mut section = Section::new(name);
            let figure = component_figure(results, &component);
            section
                .blocks
                .push(Block::figure(&figure, format!("All signals of {name}."))?);
            sections.push(section);
        }
    } else {
        sections.push(chosen);
    }
    let mut ranges = Section::new("Ranges");
    ranges.blocks.push(Block::Table(range_table(results)));
    sections.push(ranges);
    let page = Page {
        title: options.title.clone(),
        summary: vec![lead(results)],
        sections,
        ..Page::default()
    };
    page.html()
}

fn lead(results: &Results) -> String {
    match (results.time.first(), results.time.last()) {
        (Some(first), Some(last)) => format!(
            "{} signals at {} instants from {first} s to {last} s.",
            results.names.len(),
            results.time.len()
        ),
        _ => format!("{} signals, no instants.", results.names.len()),
    }
}

fn over_time(results: &Results, values: &[f64]) -> Vec<(f64, f64)> {
    results
        .time
        .iter()
        .copied()
        .zip(values.iter().copied())
        .collect()
}

fn time_figure(results: &Results, plot: &Plot) -> Result<Figure> {
    let line = |(i, name): (usize, &String)| {
        let points = over_time(results, results.signal(name)?);
        Ok::<_, Error>(Series::line(name, Role::Signal(i), points))
    };
    let series = plot
        .signals
        .iter()
        .enumerate()
        .map(line)
        .collect::<Result<_, _>>()?;
    let panel = Panel::new("time (s)", "", 2.0 * PANEL_HEIGHT, series);
    Ok(Figure::stacked(plot.title.as_str(), vec![panel]))
}

fn path_figure(results: &Results, plot: &XyPlot) -> Result<Figure> {
    let line = |(i, (x, y)): (usize, &(String, String))| {
        let (x_values, y_values) = (results.signal(x)?, results.signal(y)?);
        let points = x_values
            .iter()
            .copied()
            .zip(y_values.iter().copied())
            .collect();
        Ok::<_, Error>(Series::line(&format!("{x}, {y}"), Role::Signal(i), points))
    };
    let series = plot
        .pairs
        .iter()
        .enumerate()
        .map(line)
        .collect::<Result<_, _>>()?;
    let (x, y) = plot
        .pairs
        .first()
        .map(|(x, y)| (x.as_str(), y.as_str()))
        .unwrap_or_default();
    Ok(Figure::paths(
        plot.title.as_str(),
        1,
        vec![Panel::new(x, y, 480.0, series)],
    ))
}

/// The signals of one component.
struct Component {
    name: String,
    groups: Vec<Group>,
}

/// Signals of one prefix and of like size: (label, column).
struct Group {
    name: String,
    size: f64,
    signals: Vec<(String, usize)>,
}

fn components(results: &Results) -> Vec<Component> {
    let mut components: Vec<Component> = Vec::new();
    for (column, name) in results.names.iter().enumerate() {
        let (component, rest) = name.split_once('.').unwrap_or(("", name));
        let place = components
            .iter()
            .position(|c| c.name == component)
            .unwrap_or_else(|| {
                components.push(Component {
                    name: component.into(),
                    groups: Vec::new(),
                });
                components.len() - 1
            });
        components[place].add(rest, column, size(&results.columns[column]));
    }
    components
}

impl Component {
    fn add(&mut self, signal: &str, column: usize, size: f64) {
        let name = group_name(signal);
        let fits = |g: &&mut Group| {
            g.name == name && g.signals.len() < DISTINCT_SIGNALS && are_alike(g.size, size)
        };
        let entry = (signal.to_string(), column);
        match self.groups.iter_mut().find(fits) {
            Some(group) => {
                group.size = group.size.max(size);
                group.signals.push(entry);
            }
            None => self.groups.push(Group {
                name,
                size,
                signals: vec![entry],
            }),
        }
    }
}

/// The prefix without the last part; of an array its element's name with empty brackets.
fn group_name(signal: &str) -> String {
    match (signal.split_once('['), signal.rsplit_once('.')) {
        (Some((array, rest)), _) => {
            format!(
                "{array}[]{}",
                rest.split_once(']').map_or("", |(_, leaf)| leaf)
            )
        }
        (None, Some((prefix, _))) => prefix.into(),
        (None, None) => signal.into(),
    }
}

/// Greatest finite magnitude.
fn size(values: &[f64]) -> f64 {
    values
        .iter()
        .filter(|v| v.is_finite())
        .fold(0.0, |greatest, v| greatest.max(v.abs()))
}

fn are_alike(a: f64, b: f64) -> bool {
    a == 0.0 || b == 0.0 || (a / b < LIKE_SIZE && b / a < LIKE_SIZE)
}

fn component_figure(results: &Results, component: &Component) -> Figure {
    let panel = |group: &Group| {
        let line = |(i, (label, column)): (usize, &(String, usize))| {
            let points = over_time(results, &results.columns[*column]);
            Series::line(label, Role::Signal(i), points)
        };
        let series = group.signals.iter().enumerate().map(line).collect();
        Panel::new("time (s)", &group.name, PANEL_HEIGHT, series)
    };
    let panels = component.groups.iter().map(panel).collect();
    Figure {
        legend: LegendPlace::Right,
        ..Figure::stacked(component.name.as_str(), panels)
    }
}

fn range_table(results: &Results) -> Table {
    let header = [
        "signal",
        "first",
        "last",
        "least",
        "mean",
        "greatest",
        "not finite",
    ];
    let mut table = Table::new("Signals", &header);
    for (name, column) in results.names.iter().zip(&results.columns) {
        let finite: Vec<f64> = column.iter().copied().filter(|v| v.is_finite()).collect();
        let least = finite.iter().copied().fold(f64::NAN, f64::min);
        let greatest = finite.iter().copied().fold(f64::NAN, f64::max);
        let end = |value: Option<&f64>| short(value.copied().unwrap_or(f64::NAN));
        table.push([
            name.clone(),
            end(column.first()),
            end(column.last()),
            short(least),
            short(mean(&finite)),
            short(greatest),
            (column.len() - finite.len()).to_string(),
        ]);
    }
    table
}

/// Five significant digits.
fn short(value: f64) -> String {
    let size = value.abs();
    match value {
        v if v.is_nan() => "–".into(),
        0.0 => "0".into(),
        v if !(1e-3..1e6).contains(&size) => format!("{v:.4e}"),
        v => {
            let decimals = (4 - size.log10().floor() as i32).max(0) as usize;
            let text = format!("{v:.decimals$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
                false => text,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Results {
        let names = ["a.pose.x", "a.pose.y", "a.pose.yaw", "a.thruster[0].thrust"];
        let more = ["a.thruster[1].thrust", "b.depth", "alone"];
        let names: Vec<String> = names
            .iter()
            .chain(&more)
            .map(|n| (*n).to_string())
            .collect();
        let sizes = [60.0, 30.0, 0.5, 100.0, 90.0, f64::NAN, 1.0];
        let columns = sizes.map(|s| vec![0.0, s]).to_vec();
        Results {
            names,
            time: vec![0.0, 1.0],
            columns,
        }
    }

    #[test]
    fn signals_are_grouped_by_component_prefix_and_size() {
        let groups: Vec<(String, String, usize)> = components(&sample())
            .iter()
            .flat_map(|c| {
                c.groups
                    .iter()
                    .map(|g| (c.name.clone(), g.name.clone(), g.signals.len()))
            })
            .collect();
        let expected = [
            ("a", "pose", 2),
            ("a", "pose", 1),
            ("a", "thruster[].thrust", 2),
            ("b", "depth", 1),
            ("", "alone", 1),
        ];
        assert_eq!(
            groups,
            expected.map(|(c, g, n)| (c.to_string(), g.to_string(), n))
        );
    }

    #[test]
    fn every_signal_is_shown_and_counted() {
        let page = html(&sample(), &Options::default()).unwrap();
        for name in &sample().names {
            assert!(
                page.contains(&format!("<th scope=\"row\">{name}</th>")),
                "{name}"
            );
        }
        assert_eq!(page.matches("<svg").count(), 3);
    }

    #[test]
    fn selections_replace_the_figures_of_all_signals() {
        let plots = vec!["Heading: a.pose.yaw".parse().unwrap()];
        let paths = vec!["Path: a.pose.x, a.pose.y".parse().unwrap()];
        let chosen = Options {
            plots,
            paths,
            ..Options::default()
        };
        assert_eq!(html(&sample(), &chosen).unwrap().matches("<svg").count(), 2);
        let plots = vec!["Heading: a.pose.yow".parse().unwrap()];
        let error = html(
            &sample(),
            &Options {
                plots,
                ..Options::default()
            },
        )
        .unwrap_err();
        assert!(error.to_string().contains("a.pose.yaw"));
    }

    #[test]
    fn numbers_have_five_digits() {
        let texts = [1234.567, -0.012345678, 2.5, 1e-9, 123456.7, f64::NAN].map(short);
        assert_eq!(
            texts,
            ["1234.6", "-0.012346", "2.5", "1.0000e-9", "123457", "–"]
        );
    }
}
