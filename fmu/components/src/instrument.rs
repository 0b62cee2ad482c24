//! The common part of all sensors: a rate, a seed, a latency, a switch, and a stamp on the
//! measurements.

use fmu_kit::{ParameterError, Variables};
use serde::{Deserialize, Serialize};

/// Maximum number of samples in transit.
const MOST_LATE: f64 = 64.0;

/// Parameters of every sensor.
#[derive(Clone, Debug, Variables)]
pub struct Instrument {
    /// Samples a second
    #[var(unit = "Hz", min = 0.001, max = 1e6)]
    pub rate_hz: f64,
    /// Seed of the noise
    #[var(min = 0)]
    pub seed: i32,
    /// Time from a sample to its publication, with the stamp of the sample; at most 64 samples
    #[var(unit = "s", min = 0.0, nominal = 0.01)]
    pub latency: f64,
}

impl Instrument {
    /// Start values in the types of the mathematics.
    pub fn new(rate_hz: f64, seed: u64) -> Self {
        Self { rate_hz, seed: i32::try_from(seed).unwrap_or(i32::MAX), latency: 0.0 }
    }

    /// The seed in the type of the mathematics: an Integer of FMI has 32 bits, and is not negative
    /// here.
    pub fn seed(&self) -> u64 {
        u64::from(self.seed.unsigned_abs())
    }

    /// Places for the samples in transit.
    pub(crate) fn places(&self) -> Result<usize, ParameterError> {
        let samples = self.latency * self.rate_hz;
        if !(0.0..=MOST_LATE).contains(&samples) {
            let most = MOST_LATE / self.rate_hz;
            let reason = format!("{} s: at most {MOST_LATE} samples, here {most} s", self.latency);
            return Err(ParameterError::new("latency", reason));
        }
        Ok(if samples > 0.0 { samples as usize + 2 } else { 0 })
    }
}

/// Whether a sensor takes samples.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Switch {
    /// 0: samples as usual, 1: no new samples, the last one stays
    #[var(min = 0.0, max = 1.0)]
    pub off: f64,
}

impl Switch {
    /// Whether it is on.
    pub fn is_on(self) -> bool {
        self.off < 0.5
    }
}

/// When a sensor took its newest sample.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Stamp {
    /// Time of the newest sample
    #[var(unit = "s")]
    pub stamp: f64,
    /// 1 once there is a sample, 0 before
    #[var(min = 0.0, max = 1.0)]
    pub valid: f64,
}
