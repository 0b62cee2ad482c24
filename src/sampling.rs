//! Sample instants counted in integers: the k-th of a rate f lies at `round(k 1e9 / f)` ns.
//!
//! Counting, not adding up periods, keeps a rate such as 7 Hz free of drift for ever.

use crate::ParameterError;

/// Rates above this have periods too short for instants in nanoseconds.
const MAX_RATE_HZ: f64 = 1e6;
/// Rates below this (a sample in three years) have instants that overflow soon.
const MIN_RATE_HZ: f64 = 1e-8;

/// A clock of constant rate that starts at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampler {
    rate_hz: f64,
}

impl Sampler {
    /// A clock of `rate_hz` samples a second.
    ///
    /// # Errors
    /// The rate is not a number between 1e-8 and 1e6.
    pub fn new(rate_hz: f64) -> Result<Self, ParameterError> {
        if (MIN_RATE_HZ..=MAX_RATE_HZ).contains(&rate_hz) {
            return Ok(Self { rate_hz });
        }
        Err(ParameterError::new("rate_hz", rate_hz, "must lie between 1e-8 and 1e6 Hz"))
    }

    /// Time of sample `k` since the start (ns); the first, k = 0, is at the start itself.
    #[must_use]
    pub fn instant_ns(&self, k: u64) -> i64 {
        // Whole and fractional seconds apart: k 1e9 alone would lose nanoseconds after 104 days.
        let seconds = k as f64 / self.rate_hz;
        let whole = seconds.floor();
        let rest = (k as f64 - whole * self.rate_hz) / self.rate_hz;
        whole as i64 * 1_000_000_000 + (rest * 1e9).round() as i64
    }

    /// Time between two samples (s).
    #[must_use]
    pub fn period(&self) -> f64 {
        1.0 / self.rate_hz
    }

    /// Samples a second (Hz).
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }
}
