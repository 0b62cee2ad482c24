//! Plots over time as data: curves with the same unit at common instants.

use serde::Serialize;

use super::columns::Columns;
use super::thin;
use crate::numbers::Numbers;

/// One plot; all curves have its unit.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Plot {
    /// Plots of the same section are shown together.
    pub(super) section: String,
    pub(super) title: String,
    /// Empty if it is not known.
    pub(super) unit: String,
    t: Numbers,
    lines: Vec<Line>,
    /// Shaded between plus and minus this value.
    #[serde(skip_serializing_if = "Option::is_none")]
    band: Option<Line>,
    /// Constant bounds.
    #[serde(skip_serializing_if = "Option::is_none")]
    limits: Option<Limits>,
    /// Positions of marked instants, and the reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    marks: Option<Marks>,
    /// Values hold until the next sample.
    steps: bool,
    /// The axis points down.
    down: bool,
    /// The values are angles in degrees that continue at -180 after 180.
    wraps: bool,
}

#[derive(Debug, Clone, Serialize)]
struct Line {
    name: String,
    role: Role,
    v: Numbers,
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct Limits {
    pub(super) name: String,
    pub(super) low: f64,
    pub(super) high: f64,
}

#[derive(Debug, Clone, Serialize)]
struct Marks {
    name: String,
    at: Vec<usize>,
}

/// The meaning of a curve, which decides its colour and dashes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Role {
    Truth,
    Estimate,
    Course,
    Fix,
    Signal,
}

/// A plot with all its instants.
#[derive(Debug, Default)]
pub(super) struct Whole {
    pub(super) section: String,
    pub(super) title: String,
    pub(super) unit: String,
    pub(super) lines: Vec<(String, Role, Vec<f64>)>,
    pub(super) band: Option<(String, Vec<f64>)>,
    pub(super) limits: Option<Limits>,
    pub(super) marks: Option<(String, Vec<usize>)>,
    pub(super) steps: bool,
    pub(super) down: bool,
    pub(super) wraps: bool,
}

/// Marks of one plot.
const MARKS: usize = 200;

impl Whole {
    /// Whether there is anything to show.
    pub(super) fn is_empty(&self) -> bool {
        !self.lines.iter().any(|(_, _, values)| values.iter().any(|v| v.is_finite()))
    }

    /// The number of its value lists.
    pub(super) fn lists(&self) -> usize {
        1 + self.lines.len() + usize::from(self.band.is_some())
    }

    /// With at most about this many values.
    pub(super) fn thinned(self, columns: &Columns<'_>, numbers: usize) -> Plot {
        let curves: Vec<&[f64]> = self
            .lines
            .iter()
            .map(|(_, _, values)| values.as_slice())
            .chain(self.band.as_ref().map(|(_, values)| values.as_slice()))
            .collect();
        let marks = self.marks.as_ref().map_or(&[][..], |(_, at)| &at[..at.len().min(MARKS)]);
        let most = numbers / (curves.len() + 1);
        let places = thin::fitting(&curves, columns.time.len(), most, marks);
        let pick = |values: &[f64]| Numbers::values(places.iter().map(|&place| values[place]));
        let line = |(name, role, values): &(String, Role, Vec<f64>)| Line {
            name: name.clone(),
            role: *role,
            v: pick(values),
        };
        let at = |mark: &usize| places.binary_search(mark).ok();
        Plot {
            t: Numbers::times(places.iter().map(|&place| columns.time[place])),
            lines: self.lines.iter().map(line).collect(),
            band: self.band.as_ref().map(|(name, values)| Line {
                name: name.clone(),
                role: Role::Estimate,
                v: pick(values),
            }),
            marks: self.marks.as_ref().map(|(name, _)| Marks {
                name: name.clone(),
                at: marks.iter().filter_map(at).collect(),
            }),
            limits: self.limits,
            section: self.section,
            title: self.title,
            unit: self.unit,
            steps: self.steps,
            down: self.down,
            wraps: self.wraps,
        }
    }
}
