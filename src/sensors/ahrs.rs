//! Attitude and heading reference: roll, pitch and a heading from gyros or from a magnetic compass.
//!
//! `roll, pitch + m + n`, `heading = yaw + b + m + deviation(yaw) + disturbance + n` with white
//! noise n, correlated noise m, a constant bias b. The deviation of a compass caused by the
//! magnetism of its vehicle is `B sin psi + C cos psi + D sin 2psi + E cos 2psi` (Bowditch,
//! American Practical Navigator, chapter on compasses; there it is a correction, so of opposite
//! sign; A is in the bias).

use super::errors::{Correlated, GaussMarkov};
use super::noise::{Gaussian, Stream};
use crate::ParameterError;
use crate::attitude;
use crate::error::{each, finite, non_negative};
use crate::sampling::Rate;
use serde::{Deserialize, Serialize};

/// Parameters of an attitude and heading reference; angles in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AhrsParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of all its noise.
    pub seed: u64,
    /// Standard deviation of the white noise of roll and pitch.
    pub tilt_sigma: f64,
    /// Standard deviation of the white noise of the heading.
    pub heading_sigma: f64,
    /// Correlated error of roll and pitch.
    pub tilt_error: GaussMarkov,
    /// Correlated error of the heading.
    pub heading_error: GaussMarkov,
    /// Constant error of the heading.
    pub heading_bias: f64,
    /// Standard deviation of an additional constant error of the heading, drawn once.
    pub heading_bias_sigma: f64,
    /// Coefficients B, C, D, E of the deviation.
    pub deviation: [f64; 4],
}

impl Default for AhrsParameters {
    fn default() -> Self {
        Self {
            rate_hz: 10.0,
            seed: 5,
            tilt_sigma: 0.01,
            heading_sigma: 0.01,
            tilt_error: GaussMarkov::NONE,
            heading_error: GaussMarkov::NONE,
            heading_bias: 0.0,
            heading_bias_sigma: 0.0,
            deviation: [0.0; 4],
        }
    }
}

/// True attitude at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AhrsTruth {
    /// Roll, pitch, yaw (rad).
    pub euler: [f64; 3],
    /// Disturbance of the heading by the surroundings (rad).
    pub disturbance: f64,
}

/// Noise generators, correlated errors, bias.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AhrsMemory {
    white: Gaussian,
    correlated: Gaussian,
    /// For roll, pitch, heading (rad).
    error: [f64; 3],
    bias: f64,
}

/// An attitude and heading reference, with its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Ahrs {
    /// How often it samples.
    pub rate: Rate,
    p: AhrsParameters,
    /// For roll, pitch, heading.
    correlated: [Correlated; 3],
}

impl Ahrs {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &AhrsParameters) -> Result<Self, ParameterError> {
        let rate = Rate::new(p.rate_hz)?;
        non_negative("tilt_sigma", p.tilt_sigma)?;
        non_negative("heading_sigma", p.heading_sigma)?;
        p.tilt_error.check("tilt_error")?;
        p.heading_error.check("heading_error")?;
        finite("heading_bias", p.heading_bias)?;
        non_negative("heading_bias_sigma", p.heading_bias_sigma)?;
        each("deviation", &p.deviation, finite)?;
        let tilt = Correlated::new(&p.tilt_error, p.rate_hz);
        let heading = Correlated::new(&p.heading_error, p.rate_hz);
        Ok(Self { rate, p: *p, correlated: [tilt, tilt, heading] })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> AhrsMemory {
        let stream = |stream| Gaussian::new(self.p.seed, stream);
        let drawn = self.p.heading_bias_sigma * stream(Stream::AhrsBias).draw();
        let mut correlated = stream(Stream::AhrsCorrelated);
        AhrsMemory {
            white: stream(Stream::AhrsAttitude),
            error: self.correlated.map(|process| process.first(&mut correlated)),
            correlated,
            bias: self.p.heading_bias + drawn,
        }
    }

    /// The next sample: roll, pitch, heading (rad), roll and heading in (-pi, pi].
    pub fn sample(&self, memory: &mut AhrsMemory, truth: &AhrsTruth) -> [f64; 3] {
        let sigma = [self.p.tilt_sigma, self.p.tilt_sigma, self.p.heading_sigma];
        let [roll, pitch, heading] = core::array::from_fn(|i| {
            truth.euler[i] + memory.error[i] + sigma[i] * memory.white.draw()
        });
        for (error, process) in memory.error.iter_mut().zip(&self.correlated) {
            *error = process.next(*error, &mut memory.correlated);
        }
        let compass = memory.bias + self.deviation(truth.euler[2]) + truth.disturbance;
        [attitude::wrap(roll), pitch, attitude::wrap(heading + compass)]
    }

    fn deviation(&self, yaw: f64) -> f64 {
        let [b, c, d, e] = self.p.deviation;
        let ((sin, cos), (sin2, cos2)) = (libm::sincos(yaw), libm::sincos(2.0 * yaw));
        b * sin + c * cos + d * sin2 + e * cos2
    }
}
