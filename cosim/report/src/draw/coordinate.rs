//! An axis for the drawing library: a linear map with labelled ticks.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::prelude::Ranged;

use super::super::figure::Axis;
use super::super::ticks::Ticks;

/// A range of values on a range of drawing units.
pub(super) struct Coordinate {
    low: f64,
    high: f64,
    axis: Axis,
    ticks: Ticks,
}

impl Coordinate {
    /// The axis over a range, with ticks at its categories or round ones about `spacing` px apart.
    pub(super) fn new(axis: &Axis, range: (f64, f64), length: f64, spacing: f64) -> Self {
        let (low, high) = range;
        let ticks = match axis.categories.len() {
            0 => Ticks::new(low, high, (length / spacing).round().max(2.0) as usize),
            count => Ticks::new(0.0, (count - 1) as f64, (count - 1).max(1)),
        };
        Coordinate { low, high, axis: axis.clone(), ticks }
    }
}

impl Ranged for Coordinate {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    /// Values beyond the range are placed at its end.
    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let part = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        let part = if self.axis.reversed { 1.0 - part } else { part };
        limit.0 + (f64::from(limit.1 - limit.0) * part).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // The library asks twice: for light grid lines, of which there are none, and for ticks.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.places.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Coordinate {
    fn format_ext(&self, place: &f64) -> String {
        match self.axis.categories.get(place.round() as usize) {
            Some(name) => name.clone(),
            None => self.ticks.label(*place),
        }
    }
}
