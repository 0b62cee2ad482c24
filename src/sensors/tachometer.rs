//! Rotor speeds of the thrusters, and the corresponding thrusts: `T = gain w |w|`.

use super::noise::{Gaussian, Stream};
use crate::ParameterError;
use crate::error::{non_negative, positive};
use crate::sampling::Rate;
use serde::{Deserialize, Serialize};

/// Parameters of the tachometers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TachometerParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of their noise.
    pub seed: u64,
    /// Standard deviation (rad/s).
    pub sigma: f64,
    /// Thrust over speed squared (N.s2/rad2).
    pub thrust_gain: f64,
}

impl Default for TachometerParameters {
    fn default() -> Self {
        Self { rate_hz: 50.0, seed: 6, sigma: 0.1, thrust_gain: 0.00031 }
    }
}

/// Outputs of the tachometers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TachometerSample {
    /// Rotor speeds (rad/s).
    pub speed: [f64; 8],
    /// Thrusts of intact propellers at these speeds (N).
    pub thrust: [f64; 8],
}

/// Noise generator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TachometerMemory {
    noise: Gaussian,
}

/// Tachometers of eight thrusters, with their parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Tachometer {
    /// How often they sample.
    pub rate: Rate,
    seed: u64,
    sigma: f64,
    thrust_gain: f64,
}

impl Tachometer {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &TachometerParameters) -> Result<Self, ParameterError> {
        let rate = Rate::new(p.rate_hz)?;
        non_negative("sigma", p.sigma)?;
        positive("thrust_gain", p.thrust_gain)?;
        Ok(Self { rate, seed: p.seed, sigma: p.sigma, thrust_gain: p.thrust_gain })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> TachometerMemory {
        TachometerMemory { noise: Gaussian::new(self.seed, Stream::Tachometer) }
    }

    /// The next sample at true rotor speeds (rad/s).
    pub fn sample(&self, memory: &mut TachometerMemory, truth: &[f64; 8]) -> TachometerSample {
        let speed = truth.map(|w| w + self.sigma * memory.noise.draw());
        TachometerSample { speed, thrust: speed.map(|w| self.thrust_gain * w * w.abs()) }
    }
}
