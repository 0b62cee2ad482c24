//! Positions of all parts of a figure in pixels, computed before drawing.
//!
//! Each panel is a column of title, data area and (where shown) horizontal axis, with the vertical
//! axis at its left. Legends have their own space, so that they never cover data.

use super::figure::{Axis, Extent, Figure, LegendPlace, Panel};
use super::legend::{Legend, ROW, entries, flow};

/// Space for the vertical axis, px.
pub(super) const Y_AXIS: f64 = 70.0;
/// Space for the horizontal axis, px.
pub(super) const X_AXIS: f64 = 42.0;
const RIGHT: f64 = 22.0;
const FIGURE_TITLE: f64 = 28.0;
const PANEL_TITLE: f64 = 30.0;
const TOP: f64 = 8.0;
const ABOVE_LEGEND: f64 = 6.0;
const BETWEEN_ROWS: f64 = 18.0;

/// A rectangle, px; y grows downwards.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rect {
    /// Left edge.
    pub x: f64,
    /// Upper edge.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

impl Rect {
    /// Whether the two overlap.
    pub fn overlaps(&self, other: &Rect) -> bool {
        self.x < other.x + other.width
            && other.x < self.x + self.width
            && self.y < other.y + other.height
            && other.y < self.y + self.height
    }
}

/// Position and ranges of one panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The data area.
    pub data: Rect,
    /// Range of x shown, ascending.
    pub x: (f64, f64),
    /// Range of y shown, ascending.
    pub y: (f64, f64),
    /// Whether the horizontal axis is labelled.
    pub x_labelled: bool,
    /// The legend of the panel, if legends are at the right.
    pub legend: Legend,
}

/// The layout of a figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Width of the picture.
    pub width: f64,
    /// Height of the picture.
    pub height: f64,
    /// The panels, in the order of the figure.
    pub cells: Vec<Cell>,
    /// The common legend, if it is below.
    pub legend: Legend,
}

impl Layout {
    /// Lays out a figure.
    pub fn of(figure: &Figure) -> Self {
        let columns = figure.columns.max(1);
        let beside = match figure.legend {
            LegendPlace::Right => legend_width(figure),
            LegendPlace::Beneath => 0.0,
        };
        let available = figure.width / columns as f64 - Y_AXIS - RIGHT - beside;
        let ranges = ranges(figure);
        let sizes = data_sizes(figure, &ranges, available.max(80.0));
        let mut plan = Plan { figure, columns, beside, cells: Vec::new() };
        let (width, bottom) = plan.place(&ranges, &sizes);
        let common = match figure.legend {
            LegendPlace::Beneath => entries(&figure.panels),
            LegendPlace::Right => Vec::new(),
        };
        let space = width - Y_AXIS - RIGHT;
        let (_, legend_height) = flow(&common, space);
        Layout {
            width,
            height: bottom + ABOVE_LEGEND + legend_height + TOP,
            cells: plan.cells,
            legend: Legend::rows(common, (Y_AXIS, bottom + ABOVE_LEGEND), space),
        }
    }
}

struct Plan<'a> {
    figure: &'a Figure,
    columns: usize,
    beside: f64,
    cells: Vec<Cell>,
}

impl Plan<'_> {
    /// Places the panels row by row; returns the width of the figure and the lower edge of the last
    /// row.
    fn place(&mut self, ranges: &[Ranges], sizes: &[(f64, f64)]) -> (f64, f64) {
        let title = if self.figure.title.is_empty() { 0.0 } else { FIGURE_TITLE };
        let (mut y, mut width) = (TOP + title, 0.0_f64);
        let count = self.figure.panels.len();
        for row in (0..count).step_by(self.columns) {
            let in_row = row..(row + self.columns).min(count);
            let titled = self.figure.panels[in_row.clone()].iter().any(|p| !p.title.is_empty());
            y += if titled { PANEL_TITLE } else { 0.0 };
            let (mut x, mut bottom) = (0.0, y);
            for i in in_row {
                let data = Rect { x: x + Y_AXIS, y, width: sizes[i].0, height: sizes[i].1 };
                let x_labelled = !self.figure.common_x || i + self.columns >= count;
                let axis = if x_labelled { X_AXIS } else { BETWEEN_ROWS };
                bottom = f64::max(bottom, y + data.height + axis);
                x += Y_AXIS + data.width + RIGHT + self.beside;
                let legend = self.own_legend(&self.figure.panels[i], data);
                let Ranges { x, y } = ranges[i];
                self.cells.push(Cell { data, x, y, x_labelled, legend });
            }
            width = width.max(x);
            y = bottom;
        }
        (width.max(240.0), y)
    }

    fn own_legend(&self, panel: &Panel, data: Rect) -> Legend {
        match self.figure.legend {
            LegendPlace::Beneath => Legend::default(),
            LegendPlace::Right => {
                Legend::rows(entries([panel]), (data.x + data.width + 14.0, data.y), 1.0)
            }
        }
    }
}

/// Width of the widest legend of all panels including its distance, px.
fn legend_width(figure: &Figure) -> f64 {
    14.0 + entries(&figure.panels).iter().map(|e| e.width()).fold(0.0, f64::max)
}

/// Sizes of the data areas, px.
fn data_sizes(figure: &Figure, ranges: &[Ranges], available: f64) -> Vec<(f64, f64)> {
    let spans = ranges.iter().map(|r| (r.x.1 - r.x.0, r.y.1 - r.y.0));
    let scale = spans
        .clone()
        .zip(&figure.panels)
        .map(|((dx, dy), panel)| (available / dx).min(panel.height / dy))
        .fold(f64::INFINITY, f64::min);
    let size = |((dx, dy), panel): ((f64, f64), &Panel)| match figure.equal_scale {
        true => (dx * scale, dy * scale),
        false if figure.legend == LegendPlace::Right => {
            (available, panel.height.max(entries([panel]).len() as f64 * ROW))
        }
        false => (available, panel.height),
    };
    spans.zip(&figure.panels).map(size).collect()
}

#[derive(Clone, Copy)]
struct Ranges {
    x: (f64, f64),
    y: (f64, f64),
}

/// The ranges that each panel shows.
fn ranges(figure: &Figure) -> Vec<Ranges> {
    let extents: Vec<Extent> = figure.panels.iter().map(Panel::extent).collect();
    let all = extents.iter().copied().fold(Extent::default(), Extent::union);
    let of_panel = |(panel, extent): (&Panel, &Extent)| {
        let x = if figure.common_x { all.x } else { extent.x };
        let span = |range: Option<(f64, f64)>| range.map_or(0.0, |(low, high)| high - low);
        let margins = match figure.equal_scale {
            true => [0.04 * span(x).max(span(extent.y)); 2],
            false => [0.0, 0.05 * span(extent.y)],
        };
        Ranges { x: shown(&panel.x, x, margins[0]), y: shown(&panel.y, extent.y, margins[1]) }
    };
    figure.panels.iter().zip(&extents).map(of_panel).collect()
}

/// The range of an axis: as specified, otherwise around its categories, otherwise the data with a
/// margin.
fn shown(axis: &Axis, data: Option<(f64, f64)>, margin: f64) -> (f64, f64) {
    if let Some((low, high)) = axis.range.filter(|(low, high)| low < high) {
        return (low, high);
    }
    if !axis.categories.is_empty() {
        return (-0.5, axis.categories.len() as f64 - 0.5);
    }
    let (low, high) = data.unwrap_or((0.0, 1.0));
    // A constant (up to rounding) is shown in the middle of a readable range.
    let least = (1e-9 * low.abs().max(high.abs())).max(1e-12);
    if high - low < least {
        let half = (0.05 * high.abs()).max(0.5);
        return (low - half, high + half);
    }
    (low - margin, high + margin)
}

#[cfg(test)]
mod tests {
    use super::super::{Role, Series};
    use super::*;

    fn path(points: &[(f64, f64)]) -> Panel {
        let series = ["reference path", "path taken", "estimate"]
            .map(|name| Series::line(name, Role::Truth, points.to_vec()));
        Panel::new("x (m)", "y (m)", 300.0, series.to_vec())
    }

    #[test]
    fn paths_have_one_scale_for_both_axes_and_all_panels() {
        let long = path(&[(0.0, 0.0), (60.0, 10.0)]);
        let high = path(&[(0.0, 0.0), (25.0, 40.0)]);
        let layout = Layout::of(&Figure::paths("paths", 2, vec![long, high]));
        let scales: Vec<f64> = layout
            .cells
            .iter()
            .flat_map(|c| [c.data.width / (c.x.1 - c.x.0), c.data.height / (c.y.1 - c.y.0)])
            .collect();
        assert!(scales.iter().all(|s| (s / scales[0] - 1.0).abs() < 1e-12), "{scales:?}");
        assert!(layout.cells.iter().all(|c| c.data.height <= 300.0 + 1e-9));
        assert!(layout.width <= 860.0 + 1e-9);
    }

    #[test]
    fn legends_cover_no_data_and_stay_in_the_picture() {
        let panels = || vec![path(&[(0.0, 0.0), (9.0, 5.0)]), path(&[(0.0, 0.0), (2.0, 3.0)])];
        for place in [LegendPlace::Beneath, LegendPlace::Right] {
            let figure = Figure { legend: place, ..Figure::stacked("two", panels()) };
            let layout = Layout::of(&figure);
            let own = layout.cells.iter().flat_map(|c| c.legend.rects());
            let rects: Vec<Rect> = own.chain(layout.legend.rects()).collect();
            assert!(!rects.is_empty());
            for rect in &rects {
                assert!(layout.cells.iter().all(|c| !c.data.overlaps(rect)), "{place:?} {rect:?}");
                assert!(rect.x + rect.width <= layout.width, "{place:?} {rect:?}");
                assert!(rect.y + rect.height <= layout.height, "{place:?} {rect:?}");
            }
        }
    }

    #[test]
    fn no_data_constant_data_and_nan_give_a_usable_range() {
        for points in [vec![], vec![(0.0, f64::NAN)], vec![(1.0, 20.0), (2.0, 20.0)]] {
            let layout = Layout::of(&Figure::stacked("", vec![path(&points)]));
            let cell = &layout.cells[0];
            assert!(cell.x.0 < cell.x.1 && cell.y.0 < cell.y.1, "{points:?}");
        }
    }

    #[test]
    fn stacked_panels_share_their_horizontal_range() {
        let panels = vec![path(&[(0.0, 0.0), (9.0, 5.0)]), path(&[(3.0, 0.0), (12.0, 3.0)])];
        let layout = Layout::of(&Figure::stacked("", panels));
        assert!(layout.cells.iter().all(|c| c.x == (0.0, 12.0)));
        assert_eq!(layout.cells.iter().map(|c| c.x_labelled).collect::<Vec<_>>(), [false, true]);
    }
}
