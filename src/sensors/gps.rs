//! Horizontal position fix: the paper's "GPS", under water an acoustic fix (USBL, LBL).
//!
//! `(x, y)` of `p + R r + noise`. The simulator's receiver has no noise and 30 Hz; the paper's
//! errors suggest about 1.5 m at 10 Hz, which is the default here. The error of an acoustic fix
//! grows with the slant range rho to its transceiver: `sigma^2 + (range_sigma rho)^2`.

use super::Stream;
use super::errors::Outliers;
use super::instrument::Instrument;
use super::noise::Gaussian;
use crate::ParameterError;
use crate::attitude;
use crate::axes;
use crate::error::declared;
use crate::sampling::Rate;
use crate::vector::{add, mul, sub};
use fmu_quantity::Variables;
use serde::{Deserialize, Serialize};

/// Parameters of a position fix.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct GpsParameters {
    /// What all sensors have.
    #[var(flatten, start = Instrument::new(10.0, 3))]
    pub instrument: Instrument,
    /// Place in the body frame
    #[var(rename = "mounting", unit = "m", elements = axes::BODY)]
    pub position: [f64; 3],
    /// Standard deviation north and east at range zero
    #[var(unit = "m", min = 0.0, start = 1.5)]
    pub sigma: f64,
    /// What adds to it, as a fraction of the slant range to the beacon
    #[var(unit = "1", min = 0.0, nominal = 0.01)]
    pub range_sigma: f64,
    /// Place of the transceiver in NED
    #[var(elements = axes::NED)]
    pub beacon: [f64; 3],
    /// Fixes that are far off, as by a reflected path
    ///
    /// Their sigma is for north and east.
    #[var(unit = "m")]
    pub outlier: Outliers,
    /// Probability that a fix is lost
    #[var(unit = "1", min = 0.0, max = 1.0)]
    pub dropout_probability: f64,
}

/// True pose at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct GpsTruth {
    /// Pose of the centre of gravity
    #[var(rename = "pose", elements = axes::NED)]
    pub p_ned: [f64; 3],
    /// Pose of the centre of gravity
    ///
    /// Its part roll, pitch, yaw.
    #[var(rename = "pose", elements = axes::EULER)]
    pub euler: [f64; 3],
}

/// A position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Variables)]
pub struct GpsSample {
    /// Place of the antenna or transponder
    #[var(elements = axes::HORIZONTAL)]
    pub position: [f64; 2],
}

/// A fix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Variables)]
pub struct GpsFix {
    /// The position.
    #[var(flatten)]
    pub sample: GpsSample,
    /// Place of the antenna or transponder: standard deviation north and east that the instrument
    /// reports
    ///
    /// It does not include outliers.
    #[var(rename = "position.sigma", unit = "m")]
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
        declared(p)?;
        Ok(Self { rate: p.instrument.rate()?, p: *p })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> GpsMemory {
        let stream = |stream| self.p.instrument.noise(stream);
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
