//! Attitude and heading reference: roll, pitch and compass.
//!
//! `roll = atan2(R32, R33)`, `pitch = -asin(R31)`, `heading = atan2(R21, R11) + b`, with the bias b
//! of the compass where it is a state. Derivatives by a rotation about the body axes: Fossen (2011)
//! eq (2.28), the inverse of the matrix that turns Euler rates into body rates.

use nalgebra::Matrix3;

use super::{Observation, Sensor};
use crate::attitude::wrap;
use crate::estimation::belief::Column;
use crate::estimation::kinematics::Kinematics;

/// Cosine of pitch below which roll and heading lose their meaning.
const VERTICAL: f64 = 0.05;

/// Roll and pitch (rad) of an attitude `[roll, pitch, heading]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// Standard deviation of each (rad).
    pub sigma: f64,
}

/// Heading (rad) of an attitude `[roll, pitch, heading]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading {
    /// Standard deviation (rad).
    pub sigma: f64,
}

/// Roll, pitch and heading of a rotation, and their derivatives by a turn about the body axes.
#[must_use]
pub fn euler(rotation: &Matrix3<f64>) -> ([f64; 3], Matrix3<f64>) {
    let r = rotation;
    let sin_pitch = -r[(2, 0)].clamp(-1.0, 1.0);
    let roll = libm::atan2(r[(2, 1)], r[(2, 2)]);
    let pitch = libm::asin(sin_pitch);
    let heading = libm::atan2(r[(1, 0)], r[(0, 0)]);
    let cos_pitch = (1.0 - sin_pitch * sin_pitch).sqrt().max(VERTICAL);
    let (sin_roll, cos_roll) = libm::sincos(roll);
    let tan_pitch = sin_pitch / cos_pitch;
    let rates = Matrix3::new(
        1.0,
        sin_roll * tan_pitch,
        cos_roll * tan_pitch,
        0.0,
        cos_roll,
        -sin_roll,
        0.0,
        sin_roll / cos_pitch,
        cos_roll / cos_pitch,
    );
    ([roll, pitch, heading], rates)
}

impl Sensor<3> for Tilt {
    fn observe<const N: usize>(&self, value: &[f64; 3], motion: &Kinematics<N>) -> Observation<N> {
        let (angles, rates) = euler(&motion.rotation);
        let variance = self.sigma * self.sigma;
        Observation::new(
            2,
            [wrap(value[0] - angles[0]), value[1] - angles[1], 0.0],
            [0, 1, 2].map(|i| motion.through_rotation(&rates, i)),
            [variance, variance, 1.0],
        )
    }
}

impl Sensor<3> for Heading {
    fn observe<const N: usize>(&self, value: &[f64; 3], motion: &Kinematics<N>) -> Observation<N> {
        let (angles, rates) = euler(&motion.rotation);
        let mut row = motion.through_rotation(&rates, 2);
        if let Some(state) = motion.sensors.heading_bias {
            row[state] = 1.0;
        }
        let predicted = angles[2] + motion.optional(motion.sensors.heading_bias);
        let empty = Column::zeros();
        Observation::new(
            1,
            [wrap(value[2] - predicted), 0.0, 0.0],
            [row, empty, empty],
            [self.sigma * self.sigma, 1.0, 1.0],
        )
    }
}
