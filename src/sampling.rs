//! Sampling rates, checked. The caller counts the sample instants and decides when a sample is due.

use crate::ParameterError;

/// Rates above this have periods too short for instants in nanoseconds.
const MAX_HZ: f64 = 1e6;
/// Rates below this (a sample in three years) have instants that soon overflow.
const MIN_HZ: f64 = 1e-8;

/// Samples a second, between 1e-8 and 1e6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rate {
    hz: f64,
}

impl Rate {
    /// `rate_hz` samples a second.
    ///
    /// # Errors
    /// The rate is not a number between 1e-8 and 1e6.
    pub fn new(rate_hz: f64) -> Result<Self, ParameterError> {
        if (MIN_HZ..=MAX_HZ).contains(&rate_hz) {
            return Ok(Self { hz: rate_hz });
        }
        Err(ParameterError::new("rate_hz", rate_hz, "must lie between 1e-8 and 1e6 Hz"))
    }

    /// Time between two samples (s).
    #[must_use]
    pub fn period(&self) -> f64 {
        1.0 / self.hz
    }

    /// Samples a second (Hz).
    #[must_use]
    pub fn hz(&self) -> f64 {
        self.hz
    }
}
