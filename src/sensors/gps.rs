//! Horizontal position fix: the paper's "GPS", under water an acoustic one (USBL, LBL).
//!
//! `(x, y)` of `p + R r + noise`. The simulator's receiver is free of noise and 30 Hz; the paper's
//! errors speak for about 1.5 m at 10 Hz, which is the default here.

use super::noise::Gaussian;
use crate::ParameterError;
use crate::attitude;
use crate::error::{each, finite, non_negative};
use crate::sampling::Rate;
use crate::vector::{Vec3, add, mul};
use serde::{Deserialize, Serialize};

/// Parameters of a position fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpsParameters {
    /// Fixes a second (Hz).
    pub rate_hz: f64,
    /// Seed of its noise.
    pub seed: u64,
    /// Place of the antenna or transponder, body (m).
    pub position: [f64; 3],
    /// Standard deviation north and east (m).
    pub sigma: f64,
}

impl Default for GpsParameters {
    fn default() -> Self {
        Self { rate_hz: 10.0, seed: 3, position: [0.0; 3], sigma: 1.5 }
    }
}

/// True pose at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GpsTruth {
    /// Position of the centre of gravity, NED (m).
    pub p_ned: [f64; 3],
    /// Roll, pitch, yaw (rad).
    pub euler: [f64; 3],
}

/// A fix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GpsSample {
    /// North and east of the antenna or transponder (m).
    pub position: [f64; 2],
}

/// Noise generator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GpsMemory {
    noise: Gaussian,
}

/// A position fix, its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Gps {
    /// How often it samples.
    pub rate: Rate,
    seed: u64,
    position: Vec3,
    sigma: f64,
}

impl Gps {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &GpsParameters) -> Result<Self, ParameterError> {
        let rate = Rate::new(p.rate_hz)?;
        each("position", &p.position, finite)?;
        non_negative("sigma", p.sigma)?;
        Ok(Self { rate, seed: p.seed, position: p.position, sigma: p.sigma })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> GpsMemory {
        GpsMemory { noise: Gaussian::new(self.seed, 0) }
    }

    /// The next fix.
    pub fn sample(&self, memory: &mut GpsMemory, truth: &GpsTruth) -> GpsSample {
        let r_nb = attitude::rotation_euler(truth.euler);
        let place = add(truth.p_ned, mul(&r_nb, self.position));
        let noise: [f64; 2] = memory.noise.draw_vector(self.sigma);
        GpsSample { position: [place[0] + noise[0], place[1] + noise[1]] }
    }
}
