//! Doppler velocity log: velocity over ground at its own place, along body axes.
//!
//! `v_dvl = v + omega x r + noise`; the nominal place astern adds -1.4 r to the sway velocity.

use super::noise::Gaussian;
use crate::ParameterError;
use crate::error::{each, finite, non_negative};
use crate::sampling::Rate;
use crate::vector::{Vec3, add, angular, cross, linear};
use serde::{Deserialize, Serialize};

/// Parameters of a DVL.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DvlParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of its noise.
    pub seed: u64,
    /// Place, body (m).
    pub position: [f64; 3],
    /// Standard deviation of each axis (m/s).
    pub sigma: f64,
}

impl Default for DvlParameters {
    fn default() -> Self {
        Self { rate_hz: 7.0, seed: 2, position: [-1.4, 0.0, 0.312], sigma: 0.001 }
    }
}

/// True motion at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DvlTruth {
    /// Velocity over ground `[u, v, w, p, q, r]`, body (m/s, rad/s).
    pub nu: [f64; 6],
}

/// What the DVL shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DvlSample {
    /// Velocity over ground at the DVL, body axes (m/s).
    pub velocity: [f64; 3],
}

/// Noise generator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DvlMemory {
    noise: Gaussian,
}

/// A DVL, its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Dvl {
    /// How often it samples.
    pub rate: Rate,
    seed: u64,
    position: Vec3,
    sigma: f64,
}

impl Dvl {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &DvlParameters) -> Result<Self, ParameterError> {
        let rate = Rate::new(p.rate_hz)?;
        each("position", &p.position, finite)?;
        non_negative("sigma", p.sigma)?;
        Ok(Self { rate, seed: p.seed, position: p.position, sigma: p.sigma })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> DvlMemory {
        DvlMemory { noise: Gaussian::new(self.seed, 0) }
    }

    /// The next sample.
    pub fn sample(&self, memory: &mut DvlMemory, truth: &DvlTruth) -> DvlSample {
        let lever = cross(angular(&truth.nu), self.position);
        let noise = memory.noise.draw_vector(self.sigma);
        DvlSample { velocity: add(add(linear(&truth.nu), lever), noise) }
    }
}
