//! The ports that all sensors have: a switch, and a stamp on the measurements.

use fmu_kit::Variables;
use serde::{Deserialize, Serialize};

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
