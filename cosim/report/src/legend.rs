//! The legend: which entries a figure needs and how they flow; `layout` decides where they are
//! placed.

use super::figure::{Panel, Shape};
use super::layout::Rect;
use super::style::Role;

/// Font of legends and axis labels, px.
pub(super) const FONT: f64 = 12.0;
/// Height of one entry, px.
pub(super) const ROW: f64 = 19.0;
/// Length of the sample of the line, px.
pub(super) const SWATCH: f64 = 26.0;
/// Distance between the sample and its name, px.
pub(super) const GAP: f64 = 7.0;
const BETWEEN: f64 = 20.0;

/// One entry.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub name: String,
    pub(super) role: Role,
    pub(super) sample: Sample,
}

/// The sample before the name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sample {
    Line,
    Band,
    Mark,
}

impl Sample {
    fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Line(_) | Shape::Steps(_) => Sample::Line,
            Shape::Band(_) | Shape::Boxes(_) => Sample::Band,
            Shape::Marks(_) => Sample::Mark,
        }
    }
}

impl Entry {
    /// Width of sample and name, px. No font metrics are available: 0.58 em per letter is a safe
    /// estimate.
    pub(super) fn width(&self) -> f64 {
        SWATCH + GAP + text_width(&self.name, FONT)
    }
}

/// A safe estimate of the width of a text in a sans-serif font, px.
pub(super) fn text_width(text: &str, font: f64) -> f64 {
    0.58 * font * text.chars().count() as f64
}

/// The distinct named entries of the panels, in order of first appearance.
pub(super) fn entries<'a>(panels: impl IntoIterator<Item = &'a Panel>) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    for series in panels.into_iter().flat_map(|p| &p.series).filter(|s| !s.name.is_empty()) {
        let sample = Sample::of(&series.shape);
        let entry = Entry { name: series.name.clone(), role: series.role, sample };
        if !entries.contains(&entry) {
            entries.push(entry);
        }
    }
    entries
}

/// Upper left corners of the entries, row by row within a width, and the total height.
pub(super) fn flow(entries: &[Entry], width: f64) -> (Vec<(f64, f64)>, f64) {
    let (mut x, mut y) = (0.0, 0.0);
    let mut places = Vec::new();
    for entry in entries {
        if x > 0.0 && x + entry.width() > width {
            (x, y) = (0.0, y + ROW);
        }
        places.push((x, y));
        x += entry.width() + BETWEEN;
    }
    let height = if entries.is_empty() { 0.0 } else { y + ROW };
    (places, height)
}

/// Entries with their rectangles.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Legend {
    pub(super) entries: Vec<(Entry, Rect)>,
}

impl Legend {
    /// Lays entries out in rows from a corner, within a width.
    pub(super) fn rows(entries: Vec<Entry>, corner: (f64, f64), width: f64) -> Self {
        let (places, _) = flow(&entries, width);
        let placed = entries.into_iter().zip(places).map(|(entry, (x, y))| {
            let rect = Rect { x: corner.0 + x, y: corner.1 + y, width: entry.width(), height: ROW };
            (entry, rect)
        });
        Legend { entries: placed.collect() }
    }

    /// The rectangles of the entries.
    pub fn rects(&self) -> impl Iterator<Item = Rect> {
        self.entries.iter().map(|(_, rect)| *rect)
    }
}
