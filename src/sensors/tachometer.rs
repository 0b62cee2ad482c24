//! Rotor speeds of the thrusters, and the corresponding thrusts: `T = gain w |w|`.

use super::Stream;
use super::instrument::Instrument;
use super::noise::Gaussian;
use crate::ParameterError;
use crate::axes;
use crate::error::declared;
use crate::sampling::Rate;
use fmu_quantity::Variables;
use serde::{Deserialize, Serialize};

/// Parameters of the tachometers.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct TachometerParameters {
    /// What all sensors have.
    #[var(flatten, start = Instrument::new(50.0, 6))]
    pub instrument: Instrument,
    /// Standard deviation
    #[var(unit = "rad/s", min = 0.0, start = 0.1)]
    pub sigma: f64,
    /// Thrust over rotor speed squared
    #[var(unit = "N.s2/rad2", min = 1e-12, nominal = 1e-3, start = 0.00031)]
    pub thrust_gain: f64,
}

/// True motion at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct TachometerTruth {
    /// Rotor
    #[var(rename = "rotor", each = axes::ROTOR_SPEED)]
    pub speed: [f64; 8],
}

/// Outputs of the tachometers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Variables)]
pub struct TachometerSample {
    /// Rotor
    #[var(rename = "rotor", each = axes::ROTOR_SPEED)]
    pub speed: [f64; 8],
    /// Thruster, if its propeller is sound
    #[var(rename = "thruster", each = axes::THRUST)]
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
    p: TachometerParameters,
}

impl Tachometer {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &TachometerParameters) -> Result<Self, ParameterError> {
        declared(p)?;
        Ok(Self { rate: p.instrument.rate()?, p: *p })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> TachometerMemory {
        TachometerMemory { noise: self.p.instrument.noise(Stream::Tachometer) }
    }

    /// The next sample.
    pub fn sample(
        &self,
        memory: &mut TachometerMemory,
        truth: &TachometerTruth,
    ) -> TachometerSample {
        let speed = truth.speed.map(|w| w + self.p.sigma * memory.noise.draw());
        TachometerSample { speed, thrust: speed.map(|w| self.p.thrust_gain * w * w.abs()) }
    }
}
