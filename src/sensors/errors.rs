//! Random errors from Gaussian numbers: white noise with a slow bias, correlated noise, outliers.
//!
//! White noise of density N gives samples of standard deviation `N sqrt(rate)`. A first-order
//! Gauss-Markov process is exact at the sample instants:
//! `b_k+1 = exp(-T/tau) b_k + sigma sqrt(1 - exp(-2T/tau)) n`, where white noise of density b (the
//! "random walk" of an inertial instrument) means `sigma = b sqrt(tau/2)`.

use super::noise::Gaussian;
use fmu_quantity::Variables;
use serde::{Deserialize, Serialize};

/// Noise of an inertial instrument, the same for its three axes.
///
/// U is the unit measured; where the noise is declared, so are the units that follow from it.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct BiasNoise {
    /// density of the white noise
    ///
    /// Unit: U/sqrt(Hz).
    #[var(min = 0.0)]
    pub noise_density: f64,
    /// density of the noise that drives the slow bias
    ///
    /// Unit: U/s/sqrt(Hz).
    #[var(min = 0.0)]
    pub random_walk: f64,
    /// correlation time of the slow bias
    #[var(unit = "s", min = 1e-6)]
    pub correlation_time: f64,
    /// standard deviation of the bias after switching on
    #[var(min = 0.0)]
    pub turn_on_sigma: f64,
}

/// A [`BiasNoise`] discretised for a sample period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BiasProcess {
    white_sigma: f64,
    decay: f64,
    drive_sigma: f64,
    turn_on_sigma: f64,
}

/// The state of a three-axis [`BiasProcess`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct BiasMemory {
    noise: Gaussian,
    turn_on: [f64; 3],
    slow: [f64; 3],
}

impl BiasProcess {
    pub(super) fn new(p: &BiasNoise, rate_hz: f64) -> Self {
        let (period, tau) = (1.0 / rate_hz, p.correlation_time);
        let variance = -libm::expm1(-2.0 * period / tau) * 0.5 * tau;
        Self {
            white_sigma: p.noise_density * rate_hz.sqrt(),
            decay: libm::exp(-period / tau),
            drive_sigma: p.random_walk * variance.sqrt(),
            turn_on_sigma: p.turn_on_sigma,
        }
    }

    pub(super) fn memory(&self, mut noise: Gaussian) -> BiasMemory {
        let turn_on = noise.draw_vector(self.turn_on_sigma);
        BiasMemory { noise, turn_on, slow: [0.0; 3] }
    }

    /// The error of the next sample.
    pub(super) fn sample(&self, memory: &mut BiasMemory) -> [f64; 3] {
        core::array::from_fn(|i| {
            let error = memory.turn_on[i] + memory.slow[i] + self.white_sigma * memory.noise.draw();
            memory.slow[i] = self.decay * memory.slow[i] + self.drive_sigma * memory.noise.draw();
            error
        })
    }
}

/// An error that is correlated in time: a stationary first-order Gauss-Markov process. Over short
/// times it is a bias, over long times its mean is zero.
///
/// Its unit is that of the quantity measured.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct GaussMarkov {
    /// standard deviation
    #[var(min = 0.0, start = 0.0)]
    pub sigma: f64,
    /// time in which the correlation falls to 1/e
    #[var(unit = "s", min = 1e-6, start = 60.0)]
    pub correlation_time: f64,
}

/// A [`GaussMarkov`] discretised for a sample period; the caller stores the values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Correlated {
    sigma: f64,
    decay: f64,
    drive_sigma: f64,
}

impl Correlated {
    pub(crate) fn new(p: &GaussMarkov, rate_hz: f64) -> Self {
        let periods = 1.0 / (rate_hz * p.correlation_time);
        Self {
            sigma: p.sigma,
            decay: libm::exp(-periods),
            drive_sigma: p.sigma * (-libm::expm1(-2.0 * periods)).sqrt(),
        }
    }

    /// A value of the stationary distribution.
    pub(crate) fn first(&self, noise: &mut Gaussian) -> f64 {
        self.sigma * noise.draw()
    }

    /// The value one period after `value`.
    pub(crate) fn next(&self, value: f64, noise: &mut Gaussian) -> f64 {
        self.decay * value + self.drive_sigma * noise.draw()
    }
}

/// Occasional errors far beyond the usual noise, independent of each other.
///
/// Their unit is that of the quantity measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct Outliers {
    /// probability that a sample is one
    #[var(unit = "1", min = 0.0, max = 1.0)]
    pub probability: f64,
    /// standard deviation of their additional error
    #[var(min = 0.0)]
    pub sigma: f64,
}

impl Outliers {
    /// The additional error of the next sample: zero for most.
    pub(super) fn draw<const N: usize>(&self, noise: &mut Gaussian) -> [f64; N] {
        let outlier = noise.happens(self.probability);
        let error = noise.draw_vector(self.sigma);
        if outlier { error } else { [0.0; N] }
    }
}
