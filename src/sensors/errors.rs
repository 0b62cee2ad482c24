//! Random errors from Gaussian numbers: white noise with a slow bias, correlated noise, outliers.
//!
//! White noise of density N gives samples of standard deviation `N sqrt(rate)`. A first-order
//! Gauss-Markov process is exact at the sample instants:
//! `b_k+1 = exp(-T/tau) b_k + sigma sqrt(1 - exp(-2T/tau)) n`, where white noise of density b (the
//! "random walk" of an inertial instrument) means `sigma = b sqrt(tau/2)`.

use super::noise::{Gaussian, Stream};
use crate::ParameterError;
use crate::error::{non_negative, positive, probability};
use serde::{Deserialize, Serialize};

/// Noise of an inertial instrument, the same for its three axes. U: the unit measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasNoise {
    /// Density of the white noise (U/sqrt(Hz)).
    pub noise_density: f64,
    /// Density of the white noise that drives the slow bias (U/s/sqrt(Hz)).
    pub random_walk: f64,
    /// Correlation time of the slow bias (s).
    pub correlation_time: f64,
    /// Standard deviation of the constant bias after switching on (U).
    pub turn_on_sigma: f64,
}

impl BiasNoise {
    pub(crate) fn check(&self, name: &str) -> Result<(), ParameterError> {
        non_negative(&format!("{name}.noise_density"), self.noise_density)?;
        non_negative(&format!("{name}.random_walk"), self.random_walk)?;
        positive(&format!("{name}.correlation_time"), self.correlation_time)?;
        non_negative(&format!("{name}.turn_on_sigma"), self.turn_on_sigma)
    }
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

    pub(super) fn memory(&self, seed: u64, stream: Stream) -> BiasMemory {
        let mut noise = Gaussian::new(seed, stream);
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussMarkov {
    /// Standard deviation (unit of the quantity measured).
    pub sigma: f64,
    /// Time in which the correlation falls to 1/e (s).
    pub correlation_time: f64,
}

impl GaussMarkov {
    /// No error.
    pub const NONE: Self = Self { sigma: 0.0, correlation_time: 60.0 };

    pub(crate) fn check(&self, name: &str) -> Result<(), ParameterError> {
        non_negative(&format!("{name}.sigma"), self.sigma)?;
        positive(&format!("{name}.correlation_time"), self.correlation_time)
    }
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outliers {
    /// Probability that a sample is one.
    pub probability: f64,
    /// Standard deviation of their additional error (unit of the quantity measured).
    pub sigma: f64,
}

impl Outliers {
    pub(super) fn check(&self, name: &str) -> Result<(), ParameterError> {
        probability(&format!("{name}.probability"), self.probability)?;
        non_negative(&format!("{name}.sigma"), self.sigma)
    }

    /// The additional error of the next sample: zero for most.
    pub(super) fn draw<const N: usize>(&self, noise: &mut Gaussian) -> [f64; N] {
        let outlier = noise.happens(self.probability);
        let error = noise.draw_vector(self.sigma);
        if outlier { error } else { [0.0; N] }
    }
}
