//! Kinds of error that several sensors have, as groups of parameters.

use fmu_kit::Variables;
use rexrov::sensors;

/// Errors far beyond the usual noise that come now and then.
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
