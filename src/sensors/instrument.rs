//! What all sensors have in common.

use super::Stream;
use super::noise::Gaussian;
use crate::ParameterError;
use crate::sampling::Rate;
use fmu_quantity::Variables;

/// Rate, seed and latency of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Instrument {
    /// Samples a second
    #[var(unit = "Hz", min = 0.001, max = 1e6)]
    pub rate_hz: f64,
    /// Seed of the noise
    ///
    /// Every channel has its own stream of numbers of this seed.
    #[var(min = 0)]
    pub seed: i32,
    /// Time from a sample to its publication, with the stamp of the sample; at most 64 samples
    ///
    /// The models here do not delay their samples; their caller does.
    #[var(unit = "s", min = 0.0, nominal = 0.01)]
    pub latency: f64,
}

impl Instrument {
    /// An instrument without latency.
    #[must_use]
    pub const fn new(rate_hz: f64, seed: i32) -> Self {
        Self { rate_hz, seed, latency: 0.0 }
    }

    pub(super) fn rate(&self) -> Result<Rate, ParameterError> {
        Rate::new(self.rate_hz)
    }

    /// The random numbers of a channel.
    pub(super) fn noise(&self, stream: Stream) -> Gaussian {
        Gaussian::of(self.seed, stream)
    }
}
