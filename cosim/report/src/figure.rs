//! A figure as data: panels in a grid, each with two axes and some series.

use super::Role;

/// A picture of one or more panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Shown above the panels and to screen readers.
    pub title: String,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels side by side.
    pub columns: usize,
    /// Width of the whole picture, px (equal-scale figures may come out narrower).
    pub width: f64,
    /// Position of the legend. Never on the data.
    pub legend: LegendPlace,
    /// All panels show the same range of x, and only the lowest of a column labels it.
    pub common_x: bool,
    /// Metres per pixel are the same on both axes and in all panels (paths).
    pub equal_scale: bool,
}

/// Position of the legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LegendPlace {
    /// One legend for all panels below the picture.
    Beneath,
    /// One per panel at its right.
    Right,
}

/// One coordinate system with its series.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Shown above the panel; may be empty.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Height of the data area, px (the maximum height if the scale is equal).
    pub height: f64,
    /// The series, from bottom to top.
    pub series: Vec<Series>,
}

/// One axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// Quantity and unit: `time (s)`.
    pub label: String,
    /// Range shown; from the data if `None`. Values outside are drawn at the edge.
    pub range: Option<(f64, f64)>,
    /// Values grow to the left or downwards.
    pub reversed: bool,
    /// Names of the positions 0, 1, 2 ... instead of numbers.
    pub categories: Vec<String>,
}

/// A named data set in one style.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; series of the same name and role share one entry; empty: no entry.
    pub name: String,
    /// Style.
    pub role: Role,
    /// Data and how they are drawn.
    pub shape: Shape,
}

/// How data are drawn. NaN interrupts a line or a band.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Points joined by straight lines.
    Line(Vec<(f64, f64)>),
    /// Each value holds until the next.
    Steps(Vec<(f64, f64)>),
    /// Filled between two curves: (x, lower, upper).
    Band(Vec<(f64, f64, f64)>),
    /// Diamonds.
    Marks(Vec<(f64, f64)>),
    /// Distributions: (x, sample). Box 25-75 %, bar at the median, whiskers 5-95 %.
    Boxes(Vec<(f64, Vec<f64>)>),
}

impl Figure {
    /// Panels stacked vertically with a common horizontal axis and one legend below.
    pub fn stacked(title: impl Into<String>, panels: Vec<Panel>) -> Self {
        Figure {
            title: title.into(),
            panels,
            columns: 1,
            width: 860.0,
            legend: LegendPlace::Beneath,
            common_x: true,
            equal_scale: false,
        }
    }

    /// Paths side by side at the same scale, equal on both axes.
    pub fn paths(title: impl Into<String>, columns: usize, panels: Vec<Panel>) -> Self {
        Figure { columns, common_x: false, equal_scale: true, ..Figure::stacked(title, panels) }
    }
}

impl Panel {
    /// A panel with labelled axes.
    pub fn new(x: &str, y: &str, height: f64, series: Vec<Series>) -> Self {
        Panel { title: String::new(), x: Axis::new(x), y: Axis::new(y), height, series }
    }

    /// The same panel under a title.
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }
}

impl Axis {
    /// A numeric axis with its range from the data.
    pub fn new(label: impl Into<String>) -> Self {
        Axis { label: label.into(), ..Axis::default() }
    }
}

impl Series {
    /// A line through the points.
    pub fn line(name: &str, role: Role, points: Vec<(f64, f64)>) -> Self {
        Series { name: name.into(), role, shape: Shape::Line(points) }
    }

    /// A band between a lower and an upper curve.
    pub fn band(name: &str, role: Role, points: Vec<(f64, f64, f64)>) -> Self {
        Series { name: name.into(), role, shape: Shape::Band(points) }
    }
}

/// Ranges of finite data; `None` if there are none.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Extent {
    pub(super) x: Option<(f64, f64)>,
    pub(super) y: Option<(f64, f64)>,
}

impl Extent {
    /// The extent of both.
    pub(super) fn union(self, other: Extent) -> Extent {
        let either = |a: Option<(f64, f64)>, b: Option<(f64, f64)>| match (a, b) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (a, b) => a.or(b),
        };
        Extent { x: either(self.x, other.x), y: either(self.y, other.y) }
    }
}

impl Panel {
    /// Extent of all series.
    pub(super) fn extent(&self) -> Extent {
        self.series.iter().map(|s| s.shape.extent()).fold(Extent::default(), Extent::union)
    }
}

impl Shape {
    fn extent(&self) -> Extent {
        match self {
            Shape::Line(points) | Shape::Steps(points) | Shape::Marks(points) => Extent {
                x: range(points.iter().map(|p| p.0)),
                y: range(points.iter().map(|p| p.1)),
            },
            Shape::Band(points) => Extent {
                x: range(points.iter().map(|p| p.0)),
                y: range(points.iter().flat_map(|p| [p.1, p.2])),
            },
            Shape::Boxes(boxes) => Extent {
                x: range(boxes.iter().map(|b| b.0)),
                y: range(boxes.iter().flat_map(|b| b.1.iter().copied())),
            },
        }
    }
}

/// Smallest and greatest of the finite values.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |range, v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((low.min(v), high.max(v))),
    })
}
