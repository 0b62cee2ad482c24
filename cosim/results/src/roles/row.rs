//! The positions of values in a row of recorded data, with conversion to base units.

use super::Names;
use cosim_base::error::{Code, Error, Result};
use cosim_base::names::did_you_mean;
use cosim_base::units::Linear;
use cosim_base::units::suggested::suggested;
use cosim_core::system::Column;

/// Converts the values of a column to base units (m, rad, s, Pa).
#[derive(Debug, Clone, Copy)]
pub struct Measure(Linear);

impl Measure {
    /// By the unit defined in the description of the variable.
    pub fn of(column: &Column) -> Self {
        let unit = column.unit.as_ref();
        let defined = unit
            .and_then(|unit| unit.unit)
            .map(|unit| Linear { factor: unit.factor, offset: unit.offset });
        defined.map_or_else(|| Self::named(column.unit(), &column.name), Self)
    }

    /// By the name of the unit, or otherwise by that of the variable; an unknown unit counts as a
    /// base unit.
    pub(crate) fn named(unit: Option<&str>, variable: &str) -> Self {
        let factor = base_factor(unit.or_else(|| suggested(variable)));
        Self(Linear { factor, offset: 0.0 })
    }
}

/// By what a value in this unit is multiplied to be in base units; an unknown unit counts as one.
pub fn base_factor(unit: Option<&str>) -> f64 {
    match unit {
        Some("deg" | "°") => std::f64::consts::PI / 180.0,
        _ => 1.0,
    }
}

/// A value of a row.
#[derive(Debug, Clone, Copy)]
pub struct Place {
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

    /// Like [`Place::of`], for a variable that must exist.
    pub(super) fn needed(names: &Names<'_>, measures: &[Measure], name: &str) -> Result<Self> {
        Self::of(names, measures, name).ok_or_else(|| {
            let help = did_you_mean(name, names.ordered.iter().copied());
            Error::new(Code::UnknownName, format!("'{name}' is not recorded"))
                .help(help.unwrap_or_else(|| format!("also record it: --output-variable '{name}'")))
        })
    }

    /// The column, and its conversion to base units: a factor and an offset.
    pub fn numbers(self) -> (usize, f64, f64) {
        (self.column, self.measure.factor, self.measure.offset)
    }

    pub(crate) fn value(self, row: &[f64]) -> f64 {
        self.measure.apply(row[self.column])
    }
}

/// Values that belong together, by axis.
#[derive(Debug, Clone)]
pub struct Group<const N: usize>([Option<Place>; N]);

impl<const N: usize> Default for Group<N> {
    fn default() -> Self {
        Self([None; N])
    }
}

impl<const N: usize> Group<N> {
    pub(super) fn from_places(places: [Option<Place>; N]) -> Self {
        Self(places)
    }

    /// Those axes that are recorded.
    pub(super) fn within(
        names: &Names<'_>,
        measures: &[Measure],
        path: &str,
        axes: [&str; N],
    ) -> Self {
        Self(axes.map(|axis| Place::of(names, measures, &format!("{path}.{axis}"))))
    }

    /// Like [`Group::within`], but `None` unless all axes are recorded.
    pub(super) fn whole(
        names: &Names<'_>,
        measures: &[Measure],
        path: &str,
        axes: [&str; N],
    ) -> Self {
        let found = Self::within(names, measures, path, axes);
        if found.0.iter().all(Option::is_some) { found } else { Self::default() }
    }

    /// The places of its elements.
    pub fn places(&self) -> [Option<Place>; N] {
        self.0
    }

    /// Whether any axis is recorded.
    pub(crate) fn is_there(&self) -> bool {
        self.0.iter().any(Option::is_some)
    }

    /// Whether these axes are recorded.
    pub fn has(&self, axes: impl IntoIterator<Item = usize>) -> bool {
        axes.into_iter().all(|axis| self.0[axis].is_some())
    }

    /// The values; axes that are not recorded are 0.
    pub(crate) fn values(&self, row: &[f64]) -> [f64; N] {
        self.0.map(|place| place.map_or(0.0, |place| place.value(row)))
    }
}
