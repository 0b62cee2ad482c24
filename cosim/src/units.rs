//! Units by their dimension: exponents of the SI base units, a factor and an offset.
//!
//! FMI 2.0.5, 2.2.2 and SSP 1.0, 4.4.4 define them in the same way: a value x in the unit is
//! `factor x + offset` in base units. Two units of the same dimension convert into each other; rad
//! counts as a base unit, so a rate in Hz does not silently become one in rad/s.

pub(crate) mod recorded;
pub(crate) mod suggested;

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::{Code, Result};
use crate::xml::Element;

/// The base units in the order of the exponents.
pub const BASES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// Definitions by name.
pub type Units = BTreeMap<String, Unit>;

/// A unit by its components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Exponents of kg, m, s, A, K, mol, cd and rad.
    pub exponents: [i32; 8],
    /// Base units per unit.
    pub factor: f64,
    /// Value in base units of a zero in this unit.
    pub offset: f64,
}

/// y = factor x + offset.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Linear {
    /// Slope.
    pub factor: f64,
    /// Value at x = 0.
    pub offset: f64,
}

impl Unit {
    /// The conversion to `other`; `None` when the dimensions differ.
    pub fn to(&self, other: &Unit) -> Option<Linear> {
        (self.exponents == other.exponents).then(|| Linear {
            factor: self.factor / other.factor,
            offset: (self.offset - other.offset) / other.factor,
        })
    }

    /// The dimension as text: `kg.m.s-2`, `1` for a pure number.
    pub fn dimension(&self) -> String {
        let parts = BASES.iter().zip(self.exponents).filter(|(_, exponent)| *exponent != 0);
        let parts: Vec<String> = parts
            .map(|(base, exponent)| match exponent {
                1 => (*base).to_owned(),
                _ => format!("{base}{exponent}"),
            })
            .collect();
        if parts.is_empty() { "1".to_owned() } else { parts.join(".") }
    }

    fn read(base: &Element, file: &Path, code: Code) -> Result<Self> {
        let mut exponents = [0; 8];
        for (name, exponent) in BASES.iter().zip(&mut exponents) {
            *exponent = base.parse(name, file, code)?.unwrap_or(0);
        }
        let number = |name| base.parse::<f64>(name, file, code);
        Ok(Self {
            exponents,
            factor: number("factor")?.unwrap_or(1.0),
            offset: number("offset")?.unwrap_or(0.0),
        })
    }
}

impl Linear {
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
        let unit = Unit::read(base, file, code)?;
        if unit.factor.is_normal() && unit.offset.is_finite() {
            units.insert(name.to_owned(), unit);
        }
    }
    Ok(units)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn temperature(factor: f64, offset: f64) -> Unit {
        Unit { exponents: [0, 0, 0, 0, 1, 0, 0, 0], factor, offset }
    }

    #[test]
    fn fahrenheit_and_celsius() {
        let celsius = temperature(1.0, 273.15);
        let fahrenheit = temperature(5.0 / 9.0, 459.67 * 5.0 / 9.0);
        let there = celsius.to(&fahrenheit).unwrap();
        assert!((there.apply(100.0) - 212.0).abs() < 1e-9);
        let back = there.then(fahrenheit.to(&celsius).unwrap());
        assert!((back.apply(36.6) - 36.6).abs() < 1e-12);
    }

    #[test]
    fn dimensions_must_agree() {
        let force = Unit { exponents: [1, 1, -2, 0, 0, 0, 0, 0], factor: 1.0, offset: 0.0 };
        assert_eq!(force.to(&temperature(1.0, 0.0)), None);
        assert_eq!(force.dimension(), "kg.m.s-2");
    }
}
