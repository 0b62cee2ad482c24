//! The generic report of a result file: one figure a component with a panel for each group of
//! signals, after the figures that were asked for, and a table of ranges.

use super::figure::{Figure, LegendPlace, Panel, Series};
use super::grouping::{Component, Group, components};
use super::{Block, Page, Plot, Role, Section, Table, XyPlot, mean};
use crate::{Code, Error, Recording, Result};

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
pub fn html(recording: &Recording, options: &Options) -> Result<String> {
    let mut sections = if options.plots.is_empty() && options.paths.is_empty() {
        components(recording)
            .iter()
            .map(|c| component_section(recording, c))
            .collect::<Result<_>>()?
    } else {
        vec![chosen_section(recording, options)?]
    };
    let mut ranges = Section::new("Ranges");
    ranges.blocks.push(Block::Table(range_table(recording)));
    sections.push(ranges);
    let page = Page {
        title: options.title.clone(),
        summary: vec![lead(recording)],
        sections,
        ..Page::default()
    };
    page.html()
}

/// The one figure that was asked for, as an SVG file.
pub fn svg(recording: &Recording, options: &Options) -> Result<String> {
    match (options.paths.as_slice(), options.plots.as_slice()) {
        ([path], []) => path_figure(recording, path)?.svg(),
        ([], [plot]) => time_figure(recording, plot)?.svg(),
        _ => Err(Error::new(Code::Usage, "an SVG file holds one figure")
            .help("choose one --plot or one --xy, or write a page: a name that ends in .html")),
    }
}

fn component_section(recording: &Recording, component: &Component) -> Result<Section> {
    let name = if component.name.is_empty() { "Signals" } else { &component.name };
    let mut section = Section::new(name);
    let figure = component_figure(recording, component);
    section.blocks.push(Block::figure(&figure, format!("All signals of {name}."))?);
    Ok(section)
}

fn chosen_section(recording: &Recording, options: &Options) -> Result<Section> {
    let mut section = Section::new("Selected signals");
    for plot in &options.paths {
        let figure = path_figure(recording, plot)?;
        section.blocks.push(Block::figure(&figure, "One unit is as long on both axes.")?);
    }
    for plot in &options.plots {
        let figure = time_figure(recording, plot)?;
        let caption = format!("{} over time.", plot.signals.join(", "));
        section.blocks.push(Block::figure(&figure, caption)?);
    }
    Ok(section)
}

fn lead(recording: &Recording) -> String {
    match (recording.time().first(), recording.time().last()) {
        (Some(first), Some(last)) => format!(
            "{} signals at {} instants from {} s to {} s.",
            recording.names().len(),
            recording.time().len(),
            short(*first),
            short(*last)
        ),
        _ => format!("{} signals, no instants.", recording.names().len()),
    }
}

fn over_time(recording: &Recording, values: &[f64]) -> Vec<(f64, f64)> {
    recording.time().iter().copied().zip(values.iter().copied()).collect()
}

fn time_figure(recording: &Recording, plot: &Plot) -> Result<Figure> {
    let line = |(i, name): (usize, &String)| {
        let points = over_time(recording, recording.column(name)?);
        Ok::<_, Error>(Series::line(name, Role::Signal(i), points))
    };
    let series = plot.signals.iter().enumerate().map(line).collect::<Result<_, _>>()?;
    let panel = Panel::new("time (s)", "", 2.0 * PANEL_HEIGHT, series);
    Ok(Figure::stacked(plot.title.as_str(), vec![panel]))
}

fn path_figure(recording: &Recording, plot: &XyPlot) -> Result<Figure> {
    let line = |(i, (x, y)): (usize, &(String, String))| {
        let (x_values, y_values) = (recording.column(x)?, recording.column(y)?);
        let points = x_values.iter().copied().zip(y_values.iter().copied()).collect();
        Ok::<_, Error>(Series::line(&format!("{x}, {y}"), Role::Signal(i), points))
    };
    let series = plot.pairs.iter().enumerate().map(line).collect::<Result<_, _>>()?;
    let (x, y) = plot.pairs.first().map(|(x, y)| (x.as_str(), y.as_str())).unwrap_or_default();
    Ok(Figure::paths(plot.title.as_str(), 1, vec![Panel::new(x, y, 480.0, series)]))
}

fn component_figure(recording: &Recording, component: &Component) -> Figure {
    let panel = |group: &Group| {
        let line = |(i, (label, values)): (usize, &(String, &[f64]))| {
            Series::line(label, Role::Signal(i), over_time(recording, values))
        };
        let series = group.signals.iter().enumerate().map(line).collect();
        Panel::new("time (s)", &group.name, PANEL_HEIGHT, series)
    };
    let panels = component.groups.iter().map(panel).collect();
    Figure { legend: LegendPlace::Right, ..Figure::stacked(component.name.as_str(), panels) }
}

fn range_table(recording: &Recording) -> Table {
    let header = ["signal", "first", "last", "least", "mean", "greatest", "not finite"];
    let mut table = Table::new("Signals", &header);
    for (name, column) in recording.columns().filter(|(name, _)| !recording.is_text(name)) {
        let finite: Vec<f64> = column.iter().copied().filter(|v| v.is_finite()).collect();
        let least = finite.iter().copied().fold(f64::NAN, f64::min);
        let greatest = finite.iter().copied().fold(f64::NAN, f64::max);
        let end = |value: Option<&f64>| short(value.copied().unwrap_or(f64::NAN));
        table.push([
            name.to_string(),
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

    fn sample() -> Recording {
        let names =
            ["a.pose.x", "a.pose.y", "a.pose.yaw", "b.depth", "alone"].map(String::from).to_vec();
        let columns = [60.0, 30.0, 0.5, f64::NAN, 1.0].map(|last| vec![0.0, last]).to_vec();
        Recording::from_columns(names, vec![0.0, 1.0], columns)
    }

    #[test]
    fn every_signal_is_shown_and_counted() {
        let page = html(&sample(), &Options::default()).unwrap();
        for name in sample().names() {
            assert!(page.contains(&format!("<th scope=\"row\">{name}</th>")), "{name}");
        }
        assert_eq!(page.matches("<svg").count(), 3);
    }

    #[test]
    fn selections_replace_the_figures_of_all_signals() {
        let plots = vec!["Heading: a.pose.yaw".parse().unwrap()];
        let paths = vec!["Path: a.pose.x, a.pose.y".parse().unwrap()];
        let chosen = Options { plots, paths, ..Options::default() };
        assert_eq!(html(&sample(), &chosen).unwrap().matches("<svg").count(), 2);
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
    fn numbers_have_five_digits() {
        let texts = [1234.567, -0.012345678, 2.5, 1e-9, 123456.7, f64::NAN].map(short);
        assert_eq!(texts, ["1234.6", "-0.012346", "2.5", "1.0000e-9", "123457", "–"]);
    }
}
