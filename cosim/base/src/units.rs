//! Units in files, and conversions between them.
//!
//! FMI 2.0.5, 2.2.2 and SSP 1.0, 4.4.4 define units in the same way: a value x in the unit is
//! `factor x + offset` in base units. Two units of the same dimension convert into each other.

pub mod recorded;
pub mod suggested;

use std::collections::BTreeMap;
use std::path::Path;

use fmu_standard::BASES;
pub use fmu_standard::Unit;

use crate::error::{Code, Result};
use crate::xml::Element;

/// Definitions by name.
pub type Units = BTreeMap<String, Unit>;

/// y = factor x + offset.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Linear {
    /// Slope.
    pub factor: f64,
    /// Value at x = 0.
    pub offset: f64,
}

impl Linear {
    /// The conversion between two units; `None` when their dimensions differ.
    pub fn between(from: &Unit, to: &Unit) -> Option<Self> {
        (from.exponents == to.exponents).then(|| Linear {
            factor: from.factor / to.factor,
            offset: (from.offset - to.offset) / to.factor,
        })
    }

    /// Changes nothing.
    pub const IDENTITY: Linear = Linear { factor: 1.0, offset: 0.0 };

    /// The value of y.
    #[inline]
    pub fn apply(self, x: f64) -> f64 {
        self.factor * x + self.offset
    }

    /// The value of x for that of y.
    pub fn undo(self, y: f64) -> f64 {
        (y - self.offset) / self.factor
    }

    /// First this one, then `next`.
    #[must_use]
    pub fn then(self, next: Linear) -> Linear {
        Linear { factor: self.factor * next.factor, offset: next.apply(self.offset) }
    }
}

/// Reads `<Unit name="..."><BaseUnit .../></Unit>` elements; a unit without a base is skipped, and
/// so is one whose factor is zero or not finite: nothing converts to it.
pub fn read(list: &[Element], file: &Path, code: Code) -> Result<Units> {
    let mut units = Units::new();
    for element in list.iter().filter(|e| e.name == "Unit") {
        let name = element.require("name", file, code)?;
        let Some(base) = element.child("BaseUnit") else {
            continue;
        };
        let unit = base_unit(base, file, code)?;
        if unit.factor.is_normal() && unit.offset.is_finite() {
            units.insert(name.to_owned(), unit);
        }
    }
    Ok(units)
}

fn base_unit(base: &Element, file: &Path, code: Code) -> Result<Unit> {
    let mut exponents = [0.0; 8];
    for (name, exponent) in BASES.iter().zip(&mut exponents) {
        *exponent = f64::from(base.parse::<i32>(name, file, code)?.unwrap_or(0));
    }
    let number = |name| base.parse::<f64>(name, file, code);
    Ok(Unit {
        exponents,
        factor: number("factor")?.unwrap_or(1.0),
        offset: number("offset")?.unwrap_or(0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn temperature(factor: f64, offset: f64) -> Unit {
        Unit { exponents: [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], factor, offset }
    }

    #[test]
    fn fahrenheit_and_celsius() {
        let celsius = temperature(1.0, 273.15);
        let fahrenheit = temperature(5.0 / 9.0, 459.67 * 5.0 / 9.0);
        let there = Linear::between(&celsius, &fahrenheit).unwrap();
        assert!((there.apply(100.0) - 212.0).abs() < 1e-9);
        let back = there.then(Linear::between(&fahrenheit, &celsius).unwrap());
        assert!((back.apply(36.6) - 36.6).abs() < 1e-12);
    }

    #[test]
    fn dimensions_must_agree() {
        let force = Unit::parse("N").unwrap();
        assert_eq!(Linear::between(&force, &temperature(1.0, 0.0)), None);
    }
}
