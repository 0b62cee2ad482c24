//! Horizontal position fix: the paper's "GPS", under water an acoustic fix (USBL, LBL).
//!
//! `(x, y)` of `p + R r + noise`. The simulator's receiver has no noise and 30 Hz; the paper's
//! errors suggest about 1.5 m at 10 Hz, which is the default here. The error of an acoustic fix
//! grows with the slant range rho to its transceiver: `sigma^2 + (range_sigma rho)^2`.

use super::errors::Outliers;
use super::noise::{Gaussian, Stream};
use crate::ParameterError;
use crate::attitude;
use crate::error::{each, finite, non_negative, probability};
use crate::sampling::Rate;
use crate::vector::{add, mul, sub};
use serde::{Deserialize, Serialize};

/// Parameters of a position fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpsParameters {
    /// Fixes a second (Hz).
    pub rate_hz: f64,
    /// Seed of its noise.
    pub seed: u64,
    /// Position of the antenna or transponder, body (m).
    pub position: [f64; 3],
    /// Standard deviation north and east at range zero (m).
    pub sigma: f64,
    /// Additional standard deviation, as a fraction of the slant range.
    pub range_sigma: f64,
    /// Position of the transceiver, NED (m).
    pub beacon: [f64; 3],
    /// Outlier fixes, as by a reflected path; sigma is for north and east (m).
    pub outlier: Outliers,
    /// Probability that a fix is lost.
    pub dropout_probability: f64,
}

impl Default for GpsParameters {
    fn default() -> Self {
        Self {
            rate_hz: 10.0,
            seed: 3,
            position: [0.0; 3],
            sigma: 1.5,
            range_sigma: 0.0,
            beacon: [0.0; 3],
            outlier: Outliers::default(),
            dropout_probability: 0.0,
        }
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

/// A position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GpsSample {
    /// North and east of the antenna or transponder (m).
    pub position: [f64; 2],
}

/// A fix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GpsFix {
    /// The position.
    pub sample: GpsSample,
    /// Standard deviation north and east that the instrument reports (m); it does not include
    /// outliers.
    pub sigma: f64,
}

/// Noise generators.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GpsMemory {
    white: Gaussian,
    outliers: Gaussian,
    dropouts: Gaussian,
}

/// A position fix, with its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Gps {
    /// How often it samples.
    pub rate: Rate,
    p: GpsParameters,
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
        non_negative("range_sigma", p.range_sigma)?;
        each("beacon", &p.beacon, finite)?;
        p.outlier.check("outlier")?;
        probability("dropout_probability", p.dropout_probability)?;
        Ok(Self { rate, p: *p })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> GpsMemory {
        let stream = |stream| Gaussian::new(self.p.seed, stream);
        GpsMemory {
            white: stream(Stream::GpsPosition),
            outliers: stream(Stream::GpsOutliers),
            dropouts: stream(Stream::GpsDropouts),
        }
    }

    /// The next fix, if it is not lost.
    pub fn sample(&self, memory: &mut GpsMemory, truth: &GpsTruth) -> Option<GpsFix> {
        let r_nb = attitude::rotation_euler(truth.euler);
        let place = add(truth.p_ned, mul(&r_nb, self.p.position));
        let path = sub(place, self.p.beacon);
        let range2 = path[0] * path[0] + path[1] * path[1] + path[2] * path[2];
        let from_range = self.p.range_sigma * self.p.range_sigma * range2;
        let sigma = (self.p.sigma * self.p.sigma + from_range).sqrt();
        let noise: [f64; 2] = memory.white.draw_vector(sigma);
        let outlier: [f64; 2] = self.p.outlier.draw(&mut memory.outliers);
        let position = core::array::from_fn(|i| place[i] + noise[i] + outlier[i]);
        let lost = memory.dropouts.happens(self.p.dropout_probability);
        (!lost).then_some(GpsFix { sample: GpsSample { position }, sigma })
    }
}
