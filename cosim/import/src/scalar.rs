//! The values that a master passes on: scalars of any type, of one size.

use std::sync::Arc;

use fmu_standard::Basic;
use serde::{Deserialize, Serialize};

use super::Value;
use cosim_base::texts;

/// A scalar of any of FMI's types in 64 bits; its type is that of its variable. So a master copies,
/// compares, stores and sends all types alike, and an array of Reals is passed to an FMU as it is.
///
/// | type | bits |
/// |---|---|
/// | Real | of the `f64` |
/// | Integer, Enumeration | of the `i64`, which also holds the wider integers of FMI 3.0 |
/// | Boolean | 0 or 1 |
/// | String | its number in a table of this process ([`texts`]) |
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "[u8; 8]", into = "[u8; 8]")]
#[repr(transparent)]
pub struct Scalar(u64);

// An array of scalars is an array of f64 for FMUs.
const _: () = assert!(align_of::<Scalar>() == align_of::<f64>());

impl Scalar {
    /// A Real.
    #[inline(always)]
    pub const fn real(value: f64) -> Self {
        Self(value.to_bits())
    }

    /// Of a Real, its value.
    #[inline(always)]
    pub const fn as_real(self) -> f64 {
        f64::from_bits(self.0)
    }

    /// An Integer or an item of an Enumeration.
    #[inline]
    pub const fn integer(value: i64) -> Self {
        Self(value.cast_unsigned())
    }

    /// Of an Integer its value, of a Boolean 0 or 1.
    #[inline]
    pub const fn as_integer(self) -> i64 {
        self.0.cast_signed()
    }

    /// The nearest Integer of FMI 2.0, which has 32 bits.
    #[inline]
    pub fn as_short_integer(self) -> i32 {
        self.as_integer().clamp(i32::MIN.into(), i32::MAX.into()) as i32
    }

    /// A Boolean.
    #[inline]
    pub const fn boolean(value: bool) -> Self {
        Self(value as u64)
    }

    /// Of a Boolean, its value.
    #[inline]
    pub const fn as_boolean(self) -> bool {
        self.0 != 0
    }

    /// A String.
    pub fn text(value: &str) -> Self {
        Self(texts::number(value) as u64)
    }

    /// Of a String, its value.
    pub fn as_text(self) -> Arc<str> {
        texts::text(self.0 as f64)
    }

    /// The value of type `basic` closest to a number; of Strings, the one with this number.
    #[inline]
    pub fn of_number(basic: Basic, number: f64) -> Self {
        match basic {
            Basic::Real => Self::real(number),
            Basic::Integer => Self::integer(number.round() as i64),
            Basic::Boolean => Self::boolean(number != 0.0 && !number.is_nan()),
            Basic::String => Self(number as u64),
        }
    }

    /// As a number, in which results and manipulations represent values of all types: Booleans are
    /// 0 and 1, Strings their numbers.
    #[inline]
    pub fn number(self, basic: Basic) -> f64 {
        match basic {
            Basic::Real => self.as_real(),
            Basic::Integer => self.as_integer() as f64,
            Basic::Boolean => f64::from(u8::from(self.as_boolean())),
            Basic::String => self.0 as f64,
        }
    }

    /// As a value with its type.
    pub fn value(self, basic: Basic) -> Value {
        match basic {
            Basic::Real => Value::Real(self.as_real()),
            Basic::Integer => Value::Integer(self.as_short_integer()),
            Basic::Boolean => Value::Boolean(self.as_boolean()),
            Basic::String => Value::String(self.as_text().to_string()),
        }
    }

    /// Scalars that are all Reals.
    #[inline(always)]
    pub fn reals(scalars: &[Self]) -> &[f64] {
        // SAFETY: a Scalar has the size and the alignment of an f64, of which all bits are valid.
        unsafe { std::slice::from_raw_parts(scalars.as_ptr().cast(), scalars.len()) }
    }

    /// The same, to be written.
    #[inline(always)]
    pub fn reals_mut(scalars: &mut [Self]) -> &mut [f64] {
        // SAFETY: as above; all bits of a Scalar are valid too.
        unsafe { std::slice::from_raw_parts_mut(scalars.as_mut_ptr().cast(), scalars.len()) }
    }
}

impl From<&Value> for Scalar {
    fn from(value: &Value) -> Self {
        match value {
            Value::Real(value) => Self::real(*value),
            Value::Integer(value) => Self::integer(i64::from(*value)),
            Value::Boolean(value) => Self::boolean(*value),
            Value::String(value) => Self::text(value),
        }
    }
}

/// Little-endian, for snapshots and messages; a String has no such form ([`texts`]).
impl From<Scalar> for [u8; 8] {
    fn from(scalar: Scalar) -> Self {
        scalar.0.to_le_bytes()
    }
}

impl From<[u8; 8]> for Scalar {
    fn from(bytes: [u8; 8]) -> Self {
        Self(u64::from_le_bytes(bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_keeps_all_its_bits() {
        let odd = [-0.0, f64::from_bits(0x7FF0_0000_0000_0001), f64::INFINITY, 5e-324];
        for real in odd {
            assert_eq!(Scalar::real(real).as_real().to_bits(), real.to_bits());
        }
        // These integers have no f64.
        for integer in [i64::MIN + 1, i64::MAX, (1 << 53) + 1] {
            assert_eq!(Scalar::integer(integer).as_integer(), integer);
        }
        let scalars = odd.map(Scalar::real);
        assert_eq!(
            Scalar::reals(&scalars).iter().map(|r| r.to_bits()).collect::<Vec<_>>(),
            odd.map(f64::to_bits)
        );
        assert_eq!(<[u8; 8]>::from(scalars[3]), 1_u64.to_le_bytes());
    }

    #[test]
    fn values_and_numbers_of_each_type() {
        let values = [
            (Basic::Real, Value::Real(1.5), 1.5),
            (Basic::Integer, Value::Integer(-7), -7.0),
            (Basic::Boolean, Value::Boolean(true), 1.0),
            (Basic::String, Value::String("on".into()), texts::number("on")),
        ];
        for (basic, value, number) in values {
            let scalar = Scalar::from(&value);
            assert_eq!((scalar.number(basic), scalar.value(basic)), (number, value));
            assert_eq!(Scalar::of_number(basic, number), scalar);
        }
        // What is between two values of a type is rounded.
        assert_eq!(Scalar::of_number(Basic::Integer, 2.5), Scalar::integer(3));
        assert_eq!(Scalar::integer(1 << 40).value(Basic::Integer), Value::Integer(i32::MAX));
        assert_eq!(Scalar::of_number(Basic::Boolean, 0.5), Scalar::boolean(true));
        assert_eq!(Scalar::of_number(Basic::Boolean, f64::NAN), Scalar::boolean(false));
    }
}
