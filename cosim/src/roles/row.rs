//! Where values stand in a row of what is recorded, in base units.

use super::Names;
use crate::error::{Code, Error, Result};
use crate::names::did_you_mean;
use crate::system::Column;
use crate::units::Linear;
use crate::units::suggested::suggested;

/// What makes base units (m, rad, s, Pa) of the values of a column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measure(Linear);

impl Measure {
    /// By the unit that the description of the variable defines.
    pub(crate) fn of(column: &Column) -> Self {
        let unit = column.unit.as_ref();
        let defined = unit
            .and_then(|unit| unit.unit)
            .map(|unit| Linear { factor: unit.factor, offset: unit.offset });
        defined.map_or_else(|| Self::named(column.unit(), &column.name), Self)
    }

    /// By the name of a unit, or else by that of the variable: one that is not known is taken for a
    /// base unit.
    pub(crate) fn named(unit: Option<&str>, variable: &str) -> Self {
        let factor = match unit.or_else(|| suggested(variable)) {
            Some("deg" | "°") => std::f64::consts::PI / 180.0,
            _ => 1.0,
        };
        Self(Linear { factor, offset: 0.0 })
    }
}

/// A value of a row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    column: usize,
    measure: Linear,
}

impl Place {
    /// As it is recorded.
    pub(crate) fn plain(column: usize) -> Self {
        Self { column, measure: Linear::IDENTITY }
    }

    pub(super) fn of(names: &Names<'_>, measures: &[Measure], name: &str) -> Option<Self> {
        let column = names.place(name)?;
        Some(Self { column, measure: measures[column].0 })
    }

    /// As [`Place::of`], for a variable that must be there.
    pub(super) fn needed(names: &Names<'_>, measures: &[Measure], name: &str) -> Result<Self> {
        Self::of(names, measures, name).ok_or_else(|| {
            let help = did_you_mean(name, names.ordered.iter().copied());
            Error::new(Code::UnknownName, format!("'{name}' is not recorded"))
                .help(help.unwrap_or_else(|| format!("record it, too: --output-variable '{name}'")))
        })
    }

    /// The column, and what makes base units of it: a factor and an offset.
    pub(crate) fn numbers(self) -> (usize, f64, f64) {
        (self.column, self.measure.factor, self.measure.offset)
    }

    pub(crate) fn value(self, row: &[f64]) -> f64 {
        self.measure.apply(row[self.column])
    }
}

/// Values that belong together, by their axes.
#[derive(Debug, Clone)]
pub(crate) struct Group<const N: usize>([Option<Place>; N]);

impl<const N: usize> Default for Group<N> {
    fn default() -> Self {
        Self([None; N])
    }
}

impl<const N: usize> Group<N> {
    pub(super) fn from_places(places: [Option<Place>; N]) -> Self {
        Self(places)
    }

    /// Those of the axes that are recorded.
    pub(super) fn within(
        names: &Names<'_>,
        measures: &[Measure],
        path: &str,
        axes: [&str; N],
    ) -> Self {
        Self(axes.map(|axis| Place::of(names, measures, &format!("{path}.{axis}"))))
    }

    /// As [`Group::within`], and nothing unless all axes are recorded.
    pub(super) fn whole(
        names: &Names<'_>,
        measures: &[Measure],
        path: &str,
        axes: [&str; N],
    ) -> Self {
        let found = Self::within(names, measures, path, axes);
        if found.0.iter().all(Option::is_some) { found } else { Self::default() }
    }

    pub(crate) fn places(&self) -> [Option<Place>; N] {
        self.0
    }

    /// Whether any axis is recorded.
    pub(crate) fn is_there(&self) -> bool {
        self.0.iter().any(Option::is_some)
    }

    /// Whether these axes are recorded.
    pub(crate) fn has(&self, axes: impl IntoIterator<Item = usize>) -> bool {
        axes.into_iter().all(|axis| self.0[axis].is_some())
    }

    /// The values; what is not recorded is 0.
    pub(crate) fn values(&self, row: &[f64]) -> [f64; N] {
        self.0.map(|place| place.map_or(0.0, |place| place.value(row)))
    }
}
