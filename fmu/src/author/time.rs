//! Instants in integer nanoseconds, so that a sample instant is one number, independent of rounding
//! in the importer's sums of seconds.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Nanoseconds per second.
const NS_PER_S: f64 = 1e9;

/// An instant of simulated time in integer nanoseconds (292 years either way).
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub struct Time {
    ns: i64,
}

impl Time {
    /// The instant of this many nanoseconds.
    #[must_use]
    pub const fn from_ns(ns: i64) -> Self {
        Self { ns }
    }

    /// The instant nearest to `seconds`.
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        Self { ns: (seconds * NS_PER_S).round() as i64 }
    }

    /// Nanoseconds.
    #[must_use]
    pub const fn ns(self) -> i64 {
        self.ns
    }

    /// Seconds, rounded to the nearest `f64`.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.ns as f64 / NS_PER_S
    }

    /// This instant and `ns` nanoseconds later, clamped to the range.
    #[must_use]
    pub const fn after_ns(self, ns: i64) -> Self {
        Self { ns: self.ns.saturating_add(ns) }
    }
}

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s", self.seconds())
    }
}
