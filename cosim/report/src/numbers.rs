//! Numbers in the data of a page: a few significant digits, and null for values that JSON cannot
//! represent.

use serde::ser::{Serialize, SerializeSeq, Serializer};

/// Significant digits of values.
const VALUE: i32 = 5;
/// Significant digits of instants: enough for a day in steps of a millisecond.
const TIME: i32 = 9;

/// A list of numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Numbers {
    values: Vec<f64>,
    digits: i32,
}

impl Numbers {
    /// Values of a variable.
    pub fn values(values: impl IntoIterator<Item = f64>) -> Self {
        Self { values: values.into_iter().collect(), digits: VALUE }
    }

    /// Instants (s).
    pub fn times(values: impl IntoIterator<Item = f64>) -> Self {
        Self { values: values.into_iter().collect(), digits: TIME }
    }
}

impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.values.len()))?;
        for value in &self.values {
            list.serialize_element(&Number(rounded(*value, self.digits)))?;
        }
        list.end()
    }
}

/// A number; integers without a fraction.
struct Number(f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Number(value) = *self;
        if !value.is_finite() {
            serializer.serialize_none()
        } else if value.fract() == 0.0 && value.abs() < 1e15 {
            serializer.serialize_i64(value as i64)
        } else {
            serializer.serialize_f64(value)
        }
    }
}

/// The nearest number with this many significant digits.
pub fn rounded(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let power = digits - 1 - value.abs().log10().floor() as i32;
    match power {
        0..=300 => (value * 10_f64.powi(power)).round() / 10_f64.powi(power),
        -300..=-1 => (value / 10_f64.powi(-power)).round() * 10_f64.powi(-power),
        _ => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_what_is_not_finite_is_null() {
        let list = [1.0 / 3.0, -123_456.0, 2.0, f64::NAN, f64::INFINITY, 1e-310, 0.0];
        let text = serde_json::to_string(&Numbers::values(list)).unwrap();
        assert!(text.starts_with("[0.33333,-123460,2,null,null,"), "{text}");
        let times = serde_json::to_string(&Numbers::times([86_400.001])).unwrap();
        assert_eq!(times, "[86400.001]");
    }
}
