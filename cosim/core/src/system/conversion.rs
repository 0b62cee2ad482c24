//! The conversion of a value by a connection.

use serde::{Deserialize, Serialize};

use cosim_base::units::Linear;
use cosim_import::Scalar;

/// A change of a value between an output and an input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Conversion {
    /// For Reals: a unit conversion, or one specified in the file.
    Linear(Linear),
    /// For Integers, Booleans (0 and 1) and items of enumerations: value and its replacement.
    Map(Vec<(i32, i32)>),
}

impl Conversion {
    /// The value at the input; `None`: the map has no entry for it.
    #[inline]
    pub fn apply(&self, value: f64) -> Option<f64> {
        match self {
            Conversion::Linear(linear) => Some(linear.apply(value)),
            Conversion::Map(entries) => {
                mapped(entries, |from| f64::from(from) == value).map(f64::from)
            }
        }
    }

    /// The same for a value of the type that it converts.
    #[inline]
    pub(crate) fn of_scalar(&self, value: Scalar) -> Option<Scalar> {
        match self {
            Conversion::Linear(linear) => Some(Scalar::real(linear.apply(value.as_real()))),
            Conversion::Map(entries) => {
                let to = mapped(entries, |from| i64::from(from) == value.as_integer())?;
                Some(Scalar::integer(i64::from(to)))
            }
        }
    }
}

impl Conversion {
    /// The derivative of the value at the input with respect to that at the output; maps have no
    /// slope.
    pub(crate) fn slope(&self) -> f64 {
        match self {
            Conversion::Linear(linear) => linear.factor,
            Conversion::Map(_) => 0.0,
        }
    }
}

fn mapped(entries: &[(i32, i32)], is: impl Fn(i32) -> bool) -> Option<i32> {
    entries.iter().find(|(from, _)| is(*from)).map(|(_, to)| *to)
}

impl std::fmt::Display for Conversion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Conversion::Linear(Linear { factor, offset }) if *offset == 0.0 => {
                write!(f, "times {factor}")
            }
            Conversion::Linear(Linear { factor, offset }) => {
                write!(f, "times {factor} plus {offset}")
            }
            Conversion::Map(entries) => {
                let entries: Vec<String> =
                    entries.iter().map(|(from, to)| format!("{from} to {to}")).collect();
                write!(f, "mapped: {}", entries.join(", "))
            }
        }
    }
}
