//! Doppler velocity log: velocity over ground at its own position, from four beams.
//!
//! The beams of a Janus array are inclined by the beam angle theta from straight down, towards 45,
//! 135, 225 and 315 degrees from forward:
//! `e_i = (sin theta cos a_i, sin theta sin a_i, cos theta)`. Each measures
//! `b_i = e_i . v_h + n_i`, where v_h is the velocity `v + omega x r` along the axes of the housing
//! with its scale and correlated errors. The least-squares solution over the beams is
//!
//! ```text
//! u = sum cos(a_i) b_i / (2 sin theta),  v = sum sin(a_i) b_i / (2 sin theta),
//! w = sum b_i / (4 cos theta),           e = (b_0 - b_1 + b_2 - b_3) / (2 sqrt(2) sin theta)
//! ```
//! with the error velocity e, which is zero except for noise and scaled to have the noise of u and
//! v (Teledyne RD Instruments, ADCP Coordinate Transformation, 2010). Three beams give the one
//! solution for which e is zero. Noise of `sigma` in u, v and e is `sqrt(2) sin(theta) sigma` along
//! each beam, and so `tan(theta) / sqrt(2) sigma` in w.

use super::Stream;
use super::dvl_model::DvlParameters;
use super::errors::Correlated;
use super::noise::Gaussian;
use crate::ParameterError;
use crate::attitude;
use crate::axes;
use crate::sampling::Rate;
use crate::vector::{Vec3, add, angular, cross, linear, mul, scale};
use core::f64::consts::{FRAC_1_SQRT_2, SQRT_2};
use fmu_quantity::Variables;
use serde::{Deserialize, Serialize};

/// Cosine and sine of the azimuths of the beams, over `1 / sqrt(2)`.
const AZIMUTHS: [[f64; 2]; 4] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];

/// True motion at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct DvlTruth {
    /// Velocity over ground, body frame
    #[var(rename = "velocity", elements = axes::VELOCITY)]
    pub nu: [f64; 6],
    /// Pose of the centre of gravity: down
    #[var(rename = "pose.z", unit = "m")]
    pub z: f64,
    /// Pose of the centre of gravity
    ///
    /// Its part roll and pitch.
    #[var(rename = "pose", elements = axes::TILT)]
    pub tilt: [f64; 2],
}

/// The velocity that a DVL reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Variables)]
pub struct DvlSample {
    /// Velocity over ground at the instrument, body axes
    #[var(elements = axes::LINEAR_VELOCITY)]
    pub velocity: [f64; 3],
}

/// Everything that a DVL reports with bottom lock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DvlPing {
    /// The velocity.
    pub sample: DvlSample,
    /// Disagreement of the beams (m/s); zero with three of them.
    pub error_velocity: f64,
    /// Height of the DVL above the seabed (m); zero if no seabed is modelled.
    pub altitude: f64,
    /// Velocity along each beam, positive towards the seabed (m/s); `None` if it lost the bottom.
    pub beams: [Option<f64>; 4],
}

/// Noise generators and the correlated error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DvlMemory {
    white: Gaussian,
    correlated: Gaussian,
    outliers: Gaussian,
    dropouts: Gaussian,
    error: [f64; 3],
}

/// A DVL, with its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Dvl {
    /// How often it samples.
    pub rate: Rate,
    p: DvlParameters,
    /// Sine and cosine of the beam angle and of the misalignment.
    lean: [f64; 2],
    turn: [f64; 2],
    min_cos_tilt: f64,
    correlated: Correlated,
}

impl Dvl {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &DvlParameters) -> Result<Self, ParameterError> {
        p.check()?;
        let rate = p.instrument.rate()?;
        let sin_cos = |degrees: f64| <[f64; 2]>::from(libm::sincos(degrees.to_radians()));
        Ok(Self {
            rate,
            p: *p,
            lean: sin_cos(p.beam_angle_deg),
            turn: sin_cos(p.misalignment_deg),
            min_cos_tilt: libm::cos(p.max_tilt_deg.to_radians()),
            correlated: Correlated::new(&p.correlated_error, rate.hz()),
        })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> DvlMemory {
        let stream = |stream| self.p.instrument.noise(stream);
        let mut correlated = stream(Stream::DvlCorrelated);
        DvlMemory {
            white: stream(Stream::DvlBeams),
            error: [(); 3].map(|()| self.correlated.first(&mut correlated)),
            correlated,
            outliers: stream(Stream::DvlOutliers),
            dropouts: stream(Stream::DvlDropouts),
        }
    }

    /// The next sample; `None` without bottom lock of at least three beams.
    pub fn sample(&self, memory: &mut DvlMemory, truth: &DvlTruth) -> Option<DvlPing> {
        let lever = cross(angular(&truth.nu), self.p.position);
        let [sin, cos] = self.turn;
        let [x, y, z] = scale(add(linear(&truth.nu), lever), 1.0 + self.p.scale_error);
        let housing = add([cos * x + sin * y, cos * y - sin * x, z], memory.error);
        memory.error = memory.error.map(|e| self.correlated.next(e, &mut memory.correlated));
        let noise: [f64; 4] = memory.white.draw_vector(self.p.sigma);
        let outlier: [f64; 4] = self.p.outlier.draw(&mut memory.outliers);
        let lost = memory.dropouts.happens(self.p.dropout_probability);
        let (altitude, reached) = self.bottom(truth);
        let along = SQRT_2 * self.lean[0];
        let beams = core::array::from_fn(|i| {
            let dropped = memory.dropouts.happens(self.p.beam_dropout_probability);
            let e = self.beam(i);
            let radial = e[0] * housing[0] + e[1] * housing[1] + e[2] * housing[2];
            (reached[i] && !dropped).then_some(radial + along * (noise[i] + outlier[i]))
        });
        if lost {
            return None;
        }
        let ([u, v, w], error_velocity) = self.solve(beams)?;
        Some(DvlPing { sample: DvlSample { velocity: [u, v, w] }, error_velocity, altitude, beams })
    }

    /// Direction of a beam, axes of the housing.
    fn beam(&self, i: usize) -> Vec3 {
        let [sin, cos] = self.lean;
        let [ahead, starboard] = AZIMUTHS[i].map(|a| a * FRAC_1_SQRT_2 * sin);
        [ahead, starboard, cos]
    }

    /// Altitude (m), and which beams see the seabed.
    fn bottom(&self, truth: &DvlTruth) -> (f64, [bool; 4]) {
        let [roll, pitch] = truth.tilt;
        let r_nb = attitude::rotation_euler([roll, pitch, 0.0]);
        let upright = r_nb[2][2] >= self.min_cos_tilt;
        if self.p.seabed_depth == 0.0 {
            return (0.0, [upright; 4]);
        }
        let altitude = self.p.seabed_depth - truth.z - mul(&r_nb, self.p.position)[2];
        let reached = core::array::from_fn(|i| {
            let ([x, y, z], [sin, cos]) = (self.beam(i), self.turn);
            let down = mul(&r_nb, [cos * x - sin * y, sin * x + cos * y, z])[2];
            let level = altitude * self.lean[1] / down;
            upright && down > 0.0 && (self.p.min_altitude..=self.p.max_altitude).contains(&level)
        });
        (altitude, reached)
    }

    /// Velocity along the axes of the housing, and error velocity.
    fn solve(&self, beams: [Option<f64>; 4]) -> Option<(Vec3, f64)> {
        let mut b = beams.map(|beam| beam.unwrap_or_default());
        let mut missing = (0..4).filter(|&i| beams[i].is_none());
        if let Some(i) = missing.next() {
            // Opposite pairs of beams have the same sum.
            b[i] = b[(i + 1) % 4] + b[(i + 3) % 4] - b[(i + 2) % 4];
        }
        if missing.next().is_some() {
            return None;
        }
        let [sin, cos] = self.lean;
        let sum = |axis: usize| (0..4).map(|i| AZIMUTHS[i][axis] * b[i]).sum::<f64>();
        let velocity = [
            sum(0) * FRAC_1_SQRT_2 / (2.0 * sin),
            sum(1) * FRAC_1_SQRT_2 / (2.0 * sin),
            (b[0] + b[1] + b[2] + b[3]) / (4.0 * cos),
        ];
        let error = if beams.contains(&None) { 0.0 } else { b[0] - b[1] + b[2] - b[3] };
        Some((velocity, error * FRAC_1_SQRT_2 / (2.0 * sin)))
    }
}
