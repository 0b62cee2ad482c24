//! Attitude and heading reference: roll, pitch and a heading from gyros or from a magnetic compass.
//!
//! `roll, pitch + m + n`, `heading = yaw + b + m + deviation(yaw) + disturbance + n` with white
//! noise n, correlated noise m, a constant bias b. The deviation of a compass caused by the
//! magnetism of its vehicle is `B sin psi + C cos psi + D sin 2psi + E cos 2psi` (Bowditch,
//! American Practical Navigator, chapter on compasses; there it is a correction, so of opposite
//! sign; A is in the bias).

use super::Stream;
use super::errors::{Correlated, GaussMarkov};
use super::instrument::Instrument;
use super::noise::Gaussian;
use crate::ParameterError;
use crate::attitude;
use crate::axes;
use crate::error::declared;
use crate::sampling::Rate;
use fmu_quantity::{Member, Variables};
use serde::{Deserialize, Serialize};

/// Coefficients of the deviation of a magnetic compass.
const DEVIATION: [Member; 4] = [
    Member::new("B", "of the sine of the heading").unit("rad"),
    Member::new("C", "of the cosine of the heading").unit("rad"),
    Member::new("D", "of the sine of twice the heading").unit("rad"),
    Member::new("E", "of the cosine of twice the heading").unit("rad"),
];

/// Parameters of an attitude and heading reference.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct AhrsParameters {
    /// What all sensors have.
    #[var(flatten, start = Instrument::new(10.0, 5))]
    pub instrument: Instrument,
    /// Standard deviation of the white noise of roll and pitch
    #[var(unit = "rad", min = 0.0, nominal = 0.01, start = 0.01)]
    pub tilt_sigma: f64,
    /// Standard deviation of the white noise of the heading
    #[var(unit = "rad", min = 0.0, nominal = 0.01, start = 0.01)]
    pub heading_sigma: f64,
    /// Correlated error of roll and pitch
    #[var(unit = "rad")]
    pub tilt_error: GaussMarkov,
    /// Correlated error of the heading
    #[var(unit = "rad")]
    pub heading_error: GaussMarkov,
    /// Constant error of the heading
    #[var(unit = "rad")]
    pub heading_bias: f64,
    /// Standard deviation of another constant error of the heading, drawn once
    #[var(unit = "rad", min = 0.0)]
    pub heading_bias_sigma: f64,
    /// Error of a magnetic compass on the true heading, coefficient
    #[var(elements = DEVIATION)]
    pub deviation: [f64; 4],
}

/// True attitude at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct AhrsTruth {
    /// True motion: Attitude
    #[var(rename = "vehicle.pose", elements = axes::EULER)]
    pub euler: [f64; 3],
    /// What the surroundings add to the heading, as steel does to that of a compass
    #[var(unit = "rad")]
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
        declared(p)?;
        let rate = p.instrument.rate()?;
        let tilt = Correlated::new(&p.tilt_error, rate.hz());
        let heading = Correlated::new(&p.heading_error, rate.hz());
        Ok(Self { rate, p: *p, correlated: [tilt, tilt, heading] })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> AhrsMemory {
        let stream = |stream| self.p.instrument.noise(stream);
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
