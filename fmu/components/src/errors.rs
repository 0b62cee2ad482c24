//! Error models that several sensors have, and that filters allow for, as groups of parameters.

use fmu_kit::Variables;
use rexrov::sensors::{self, BiasNoise};

/// Occasional errors far beyond the usual noise.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Outliers {
    /// probability that a sample is one
    #[var(unit = "1", min = 0.0, max = 1.0)]
    pub probability: f64,
    /// standard deviation of their additional error
    #[var(min = 0.0)]
    pub sigma: f64,
}

impl From<sensors::Outliers> for Outliers {
    fn from(o: sensors::Outliers) -> Self {
        Self { probability: o.probability, sigma: o.sigma }
    }
}

impl From<Outliers> for sensors::Outliers {
    fn from(o: Outliers) -> Self {
        Self { probability: o.probability, sigma: o.sigma }
    }
}

/// An error that is correlated in time: a first-order Gauss-Markov process.
#[derive(Clone, Copy, Debug, Variables)]
pub struct GaussMarkov {
    /// standard deviation
    #[var(min = 0.0)]
    pub sigma: f64,
    /// time in which the correlation falls to 1/e
    #[var(unit = "s", min = 1e-6)]
    pub correlation_time: f64,
}

impl From<sensors::GaussMarkov> for GaussMarkov {
    fn from(g: sensors::GaussMarkov) -> Self {
        Self { sigma: g.sigma, correlation_time: g.correlation_time }
    }
}

impl From<GaussMarkov> for sensors::GaussMarkov {
    fn from(g: GaussMarkov) -> Self {
        Self { sigma: g.sigma, correlation_time: g.correlation_time }
    }
}

/// White noise and slow bias of the accelerometers.
#[derive(Clone, Copy, Debug, Variables)]
pub struct AccelerometerNoise {
    /// density of the white noise
    #[var(unit = "m/(s2.Hz0.5)", min = 0.0)]
    pub noise_density: f64,
    /// density of the noise that drives the slow bias
    #[var(unit = "m/(s3.Hz0.5)", min = 0.0)]
    pub random_walk: f64,
    /// correlation time of the slow bias
    #[var(unit = "s", min = 1e-6)]
    pub correlation_time: f64,
    /// standard deviation of the bias after switching on
    #[var(unit = "m/s2", min = 0.0)]
    pub turn_on_sigma: f64,
}

/// White noise and slow bias of the gyros.
#[derive(Clone, Copy, Debug, Variables)]
pub struct GyroNoise {
    /// density of the white noise
    #[var(unit = "rad/(s.Hz0.5)", min = 0.0)]
    pub noise_density: f64,
    /// density of the noise that drives the slow bias
    #[var(unit = "rad/(s2.Hz0.5)", min = 0.0)]
    pub random_walk: f64,
    /// correlation time of the slow bias
    #[var(unit = "s", min = 1e-6)]
    pub correlation_time: f64,
    /// standard deviation of the bias after switching on
    #[var(unit = "rad/s", min = 0.0)]
    pub turn_on_sigma: f64,
}

/// Both instruments have the same kinds of error, in different units.
macro_rules! noise {
    ($($instrument:ident),+) => {$(
        impl From<BiasNoise> for $instrument {
            fn from(b: BiasNoise) -> Self {
                let BiasNoise { noise_density, random_walk, correlation_time, turn_on_sigma } = b;
                Self { noise_density, random_walk, correlation_time, turn_on_sigma }
            }
        }

        impl From<$instrument> for BiasNoise {
            fn from(i: $instrument) -> Self {
                let $instrument { noise_density, random_walk, correlation_time, turn_on_sigma } = i;
                Self { noise_density, random_walk, correlation_time, turn_on_sigma }
            }
        }
    )+};
}

noise!(AccelerometerNoise, GyroNoise);
