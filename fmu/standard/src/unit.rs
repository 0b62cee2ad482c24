//! Units by their dimension, and unit expressions (FMI 2.0.4, section 2.2.2; SSP 1.0, 4.4.4).
//!
//! `N.m`, `kg.m2/s`, `m/(s2.Hz0.5)`: symbols with an optional exponent, joined by `.` and `/` from
//! left to right, parentheses after a `/`. The radian counts as a base unit, so a rate in Hz is not
//! silently one in rad/s.

use crate::number;

/// A unit: `value in base units = factor * value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Exponents of [`BASES`]; only whole ones can be written in a description.
    pub exponents: [f64; 8],
    /// Base units per unit.
    pub factor: f64,
    /// Value in base units of a zero in this unit.
    pub offset: f64,
}

/// The base units, in the order of the standard's attributes.
pub const BASES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// Symbols that are not base units: exponents of `BASES`, factor, offset.
#[rustfmt::skip]
const DERIVED: [(&str, [i8; 8], f64, f64); 22] = [
    ("1",    [0, 0, 0, 0, 0, 0, 0, 0],   1.0,    0.0),
    ("%",    [0, 0, 0, 0, 0, 0, 0, 0],   0.01,   0.0),
    ("g",    [1, 0, 0, 0, 0, 0, 0, 0],   1e-3,   0.0),
    ("mm",   [0, 1, 0, 0, 0, 0, 0, 0],   1e-3,   0.0),
    ("cm",   [0, 1, 0, 0, 0, 0, 0, 0],   1e-2,   0.0),
    ("km",   [0, 1, 0, 0, 0, 0, 0, 0],   1e3,    0.0),
    ("us",   [0, 0, 1, 0, 0, 0, 0, 0],   1e-6,   0.0),
    ("ms",   [0, 0, 1, 0, 0, 0, 0, 0],   1e-3,   0.0),
    ("min",  [0, 0, 1, 0, 0, 0, 0, 0],   60.0,   0.0),
    ("h",    [0, 0, 1, 0, 0, 0, 0, 0],   3600.0, 0.0),
    ("degC", [0, 0, 0, 0, 1, 0, 0, 0],   1.0,    273.15),
    ("deg",  [0, 0, 0, 0, 0, 0, 0, 1],   std::f64::consts::PI / 180.0, 0.0),
    ("rev",  [0, 0, 0, 0, 0, 0, 0, 1],   std::f64::consts::TAU, 0.0),
    ("Hz",   [0, 0, -1, 0, 0, 0, 0, 0],  1.0,    0.0),
    ("N",    [1, 1, -2, 0, 0, 0, 0, 0],  1.0,    0.0),
    ("Pa",   [1, -1, -2, 0, 0, 0, 0, 0], 1.0,    0.0),
    ("kPa",  [1, -1, -2, 0, 0, 0, 0, 0], 1e3,    0.0),
    ("bar",  [1, -1, -2, 0, 0, 0, 0, 0], 1e5,    0.0),
    ("J",    [1, 2, -2, 0, 0, 0, 0, 0],  1.0,    0.0),
    ("W",    [1, 2, -3, 0, 0, 0, 0, 0],  1.0,    0.0),
    ("V",    [1, 2, -3, -1, 0, 0, 0, 0], 1.0,    0.0),
    ("T",    [1, 0, -2, -1, 0, 0, 0, 0], 1.0,    0.0),
];

impl Unit {
    const ONE: Self = Self { exponents: [0.0; 8], factor: 1.0, offset: 0.0 };

    /// Reads a unit expression.
    ///
    /// # Errors
    /// What cannot be read.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parser = Parser { rest: text };
        let unit = parser.product()?;
        match parser.rest {
            "" => Ok(unit),
            rest => Err(format!("unit \"{text}\": cannot read \"{rest}\"")),
        }
    }

    /// Whether the standard can express it: all exponents are whole.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.exponents.iter().all(|e| e.fract() == 0.0 && e.abs() < 100.0)
    }

    /// The attributes of its element `BaseUnit`.
    #[must_use]
    pub fn attributes(&self) -> Vec<(&'static str, String)> {
        let bases = BASES.into_iter().zip(self.exponents).filter(|(_, exponent)| *exponent != 0.0);
        let mut attributes: Vec<_> =
            bases.map(|(base, exponent)| (base, exponent.to_string())).collect();
        let others = [("factor", self.factor, 1.0), ("offset", self.offset, 0.0)];
        let others = others.into_iter().filter(|(_, value, usual)| value != usual);
        attributes.extend(others.map(|(name, value, _)| (name, number(value))));
        attributes
    }

    /// The dimension as text: `kg.m.s-2`, `1` for a pure number.
    #[must_use]
    pub fn dimension(&self) -> String {
        let parts = BASES.iter().zip(self.exponents).filter(|(_, exponent)| *exponent != 0.0);
        let parts: Vec<String> = parts
            .map(|(base, exponent)| match exponent {
                1.0 => (*base).to_owned(),
                _ => format!("{base}{exponent}"),
            })
            .collect();
        if parts.is_empty() { "1".to_owned() } else { parts.join(".") }
    }

    fn times(mut self, other: &Self, power: f64) -> Self {
        for (own, theirs) in self.exponents.iter_mut().zip(other.exponents) {
            *own += power * theirs;
        }
        self.factor *= power_of(other.factor, power);
        // An offset has a meaning only if the symbol stands alone.
        self.offset = if self == Self::ONE { other.offset } else { self.offset };
        self
    }

    fn symbol(name: &str) -> Option<Self> {
        if let Some(index) = BASES.iter().position(|base| *base == name) {
            let mut unit = Self::ONE;
            *unit.exponents.get_mut(index)? = 1.0;
            return Some(unit);
        }
        let (_, exponents, factor, offset) =
            *DERIVED.iter().find(|(symbol, ..)| *symbol == name)?;
        Some(Self { exponents: exponents.map(f64::from), factor, offset })
    }
}

/// `base^power` for the small powers that units have, exactly the same on every machine.
fn power_of(base: f64, power: f64) -> f64 {
    let whole = power.trunc() as i32;
    let root = if power.fract() == 0.0 { 1.0 } else { base.sqrt() };
    (0..whole.abs()).fold(
        root,
        |product, _| {
            if whole < 0 { product / base } else { product * base }
        },
    )
}

struct Parser<'a> {
    rest: &'a str,
}

impl<'a> Parser<'a> {
    fn product(&mut self) -> Result<Unit, String> {
        let mut unit = Unit::ONE;
        let mut sign = 1.0;
        loop {
            let (factor, power) = self.factor()?;
            unit = if unit == Unit::ONE && sign * power == 1.0 {
                factor
            } else {
                unit.times(&factor, sign * power)
            };
            sign = match self.rest.chars().next() {
                Some('.') => 1.0,
                Some('/') => -1.0,
                _ => return Ok(unit),
            };
            self.skip(1);
        }
    }

    fn factor(&mut self) -> Result<(Unit, f64), String> {
        if self.rest.starts_with('(') {
            self.skip(1);
            let unit = self.product()?;
            if !self.rest.starts_with(')') {
                return Err("a unit's parenthesis is not closed".to_owned());
            }
            self.skip(1);
            return Ok((unit, 1.0));
        }
        if self.rest.starts_with('1') {
            self.skip(1);
            return Ok((Unit::ONE, 1.0));
        }
        let name = self.take(|c| c.is_alphabetic() || c == '%');
        let unit = Unit::symbol(name).ok_or_else(|| {
            let hint = "write N.m for newton metre, m/s2 for metre per second squared";
            format!("unknown unit symbol \"{name}\"; {hint}")
        })?;
        let exponent = self.exponent();
        let power = if exponent.is_empty() { Ok(1.0) } else { exponent.parse() };
        power
            .map(|power| (unit, power))
            .map_err(|_| format!("\"{exponent}\" is no exponent of the unit {name}"))
    }

    /// `-`, digits, and a fraction: a dot counts only before a digit.
    fn exponent(&mut self) -> &'a str {
        let digits = |text: &str| text.chars().take_while(char::is_ascii_digit).count();
        let sign = usize::from(self.rest.starts_with('-'));
        let mut length = sign + digits(self.rest.get(sign..).unwrap_or_default());
        if let Some(fraction) = self.rest.get(length..).and_then(|rest| rest.strip_prefix('.')) {
            let more = digits(fraction);
            length += if more > 0 && length > sign { 1 + more } else { 0 };
        }
        let (exponent, rest) = self.rest.split_at(length);
        self.rest = rest;
        exponent
    }

    fn take(&mut self, wanted: impl Fn(char) -> bool) -> &'a str {
        let end = self.rest.find(|c| !wanted(c)).unwrap_or(self.rest.len());
        let (taken, rest) = self.rest.split_at(end);
        self.rest = rest;
        taken
    }

    fn skip(&mut self, bytes: usize) {
        self.rest = self.rest.get(bytes..).unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exponents(text: &str) -> [f64; 8] {
        Unit::parse(text).unwrap().exponents
    }

    #[test]
    fn products_and_quotients_add_exponents() {
        assert_eq!(exponents("N.m"), [1.0, 2.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(exponents("kg.m2/s"), [1.0, 2.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(exponents("N/(rad/s)"), [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
        assert_eq!(exponents("1/s"), [0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(exponents("m.s-2"), [0.0, 1.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn half_exponents_are_read_but_not_whole() {
        let unit = Unit::parse("m/(s2.Hz0.5)").unwrap();
        assert_eq!(unit.exponents[..3], [0.0, 1.0, -1.5]);
        assert!(!unit.is_whole());
    }

    #[test]
    fn factors_and_offsets() {
        assert_eq!(Unit::parse("km/h").unwrap().factor, 1000.0 / 3600.0);
        assert_eq!(Unit::parse("cm2").unwrap().factor, 1e-4);
        assert_eq!(Unit::parse("degC").unwrap().offset, 273.15);
    }

    #[test]
    fn mistakes_are_named() {
        assert!(Unit::parse("Nm").unwrap_err().contains("\"Nm\""));
        assert!(Unit::parse("m/(s").unwrap_err().contains("not closed"));
        assert!(Unit::parse("m s").unwrap_err().contains("\" s\""));
        assert!(Unit::parse("").is_err());
    }

    #[test]
    fn dimension_and_attributes_are_as_written_in_files() {
        assert_eq!(Unit::parse("N").unwrap().dimension(), "kg.m.s-2");
        let attributes = Unit::parse("deg/s").unwrap().attributes();
        let factor = "0.017453292519943295".to_owned();
        assert_eq!(attributes[..2], [("s", "-1".to_owned()), ("rad", "1".to_owned())]);
        assert_eq!(attributes[2..], [("factor", factor)]);
    }
}
