//! Time as integer nanoseconds; seconds as `f64` exist only at the edges (files, FMI calls).
//!
//! Instants are compared and added exactly, so a run of any length has no drift, and two
//! components whose steps end together are seen to do so.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::{Code, Error, Result};

/// An instant or a duration in nanoseconds.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Hash, Serialize, Deserialize,
)]
pub struct Time(i64);

const NANOSECONDS: f64 = 1e9;

impl Time {
    /// Zero.
    pub const ZERO: Time = Time(0);

    /// After all instants: the stop time of who does not know one.
    pub const NEVER: Time = Time(i64::MAX);

    /// From nanoseconds.
    pub const fn from_nanoseconds(ns: i64) -> Self {
        Self(ns)
    }

    /// The nearest nanosecond to `seconds`; `name` is what the value is, for the error.
    pub fn from_seconds(seconds: f64, name: &str) -> Result<Self> {
        let ns = (seconds * NANOSECONDS).round();
        // 2^62 ns (146 years) leaves room for additions.
        if ns.is_finite() && ns.abs() < (1_i64 << 62) as f64 {
            return Ok(Self(ns as i64));
        }
        Err(Error::new(Code::Timing, format!("{name} is {seconds} s"))
            .why("time is counted in nanoseconds and must stay within 146 years"))
    }

    /// Like [`Time::from_seconds`], and greater than zero.
    pub fn positive(seconds: f64, name: &str) -> Result<Self> {
        let time = Self::from_seconds(seconds, name)?;
        if time.0 > 0 {
            return Ok(time);
        }
        Err(Error::new(Code::Timing, format!("{name} is {seconds} s"))
            .why("it must be at least one nanosecond"))
    }

    /// Seconds, rounded once.
    pub fn seconds(self) -> f64 {
        self.0 as f64 / NANOSECONDS
    }

    /// Nanoseconds.
    pub const fn nanoseconds(self) -> i64 {
        self.0
    }

    /// The greatest duration of which both are multiples.
    #[must_use]
    pub fn gcd(self, other: Time) -> Time {
        let (mut a, mut b) = (self.0, other.0);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        Time(a.abs())
    }

    /// Whether this is a whole multiple of `base`.
    pub fn is_multiple_of(self, base: Time) -> bool {
        base.0 != 0 && self.0 % base.0 == 0
    }
}

impl std::ops::Add for Time {
    type Output = Time;
    fn add(self, other: Time) -> Time {
        Time(self.0 + other.0)
    }
}

impl std::ops::Sub for Time {
    type Output = Time;
    fn sub(self, other: Time) -> Time {
        Time(self.0 - other.0)
    }
}

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s", self.seconds())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_steps_are_exact() {
        let step = Time::from_seconds(0.1, "step").unwrap();
        assert_eq!(step.nanoseconds(), 100_000_000);
        assert_eq!((step + step + step).seconds(), 0.3);
    }

    #[test]
    fn no_number_that_is_no_time() {
        for bad in [f64::NAN, f64::INFINITY, 1e300] {
            assert!(Time::from_seconds(bad, "t").is_err());
        }
        assert!(Time::positive(0.0, "step").is_err());
        assert!(Time::positive(1e-12, "step").is_err());
    }

    #[test]
    fn gcd_of_steps() {
        let of = |s| Time::from_seconds(s, "s").unwrap();
        assert_eq!(of(0.05).gcd(of(0.02)), of(0.01));
    }
}
