//! What all sensors have: a rate, a seed, a place, a switch, and a stamp on what they measured.

use crate::groups::Vector;
use fmu_kit::{Time, Variables};
use serde::{Deserialize, Serialize};

/// Parameters of every sensor.
#[derive(Clone, Debug, Variables)]
pub struct Instrument {
    /// Samples a second
    #[var(unit = "Hz", min = 0.001, max = 1e6)]
    pub rate_hz: f64,
    /// Seed of the noise
    #[var(min = 0)]
    pub seed: i32,
    /// Place in the body frame
    #[var(unit = "m")]
    pub mounting: Vector,
}

impl Instrument {
    /// Start values as the mathematics has them.
    pub fn new(rate_hz: f64, seed: u64, position_body: [f64; 3]) -> Self {
        let seed = i32::try_from(seed).unwrap_or(i32::MAX);
        Self { rate_hz, seed, mounting: position_body.into() }
    }

    /// The seed as the mathematics has it: an Integer of FMI is 32 bits wide, and here not negative.
    pub fn seed(&self) -> u64 {
        u64::from(self.seed.unsigned_abs())
    }
}

/// Whether a sensor takes samples.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Switch {
    /// 1: samples as usual, 0: no new samples, the last one stays
    #[var(min = 0.0, max = 1.0)]
    pub enabled: f64,
}

impl Switch {
    /// On.
    pub fn is_on(self) -> bool {
        self.enabled >= 0.5
    }
}

impl Default for Switch {
    fn default() -> Self {
        Self { enabled: 1.0 }
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

impl Stamp {
    /// A sample taken now.
    pub fn at(now: Time) -> Self {
        Self { stamp: now.seconds(), valid: 1.0 }
    }
}
