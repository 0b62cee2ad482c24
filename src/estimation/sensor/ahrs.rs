//! Attitude and heading reference: roll, pitch and compass.
//!
//! `roll = atan2(R32, R33)`, `pitch = -asin(R31)`, `heading = atan2(R21, R11) + b`, with the bias b
//! of the compass if it is a state. Derivatives by a rotation about the body axes: Fossen (2011) eq
//! (2.28), the inverse of the matrix that maps Euler rates to body rates.

use nalgebra::{Matrix3, Vector3};

use super::{Observation, Sensor};
use crate::attitude::wrap;
use crate::estimation::kinematics::Kinematics;

/// Cosine of pitch below which roll and heading become meaningless.
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

/// Roll, pitch and heading of a rotation.
#[must_use]
pub fn euler(rotation: &Matrix3<f64>) -> [f64; 3] {
    let [roll, pitch] = tilt(rotation);
    [roll, pitch, heading(rotation)]
}

fn tilt(r: &Matrix3<f64>) -> [f64; 2] {
    [libm::atan2(r[(2, 1)], r[(2, 2)]), libm::asin((-r[(2, 0)]).clamp(-1.0, 1.0))]
}

fn heading(rotation: &Matrix3<f64>) -> f64 {
    libm::atan2(rotation[(1, 0)], rotation[(0, 0)])
}

/// Derivatives of roll, pitch and heading by a rotation about the body axes: one column for each
/// angle.
#[must_use]
pub fn euler_by_turn(rotation: &Matrix3<f64>) -> [Vector3<f64>; 3] {
    let [down_x, down_y, down_z] = [0, 1, 2].map(|i| rotation[(2, i)]);
    let across = (down_y * down_y + down_z * down_z).sqrt();
    let (sin_roll, cos_roll) =
        if across > 0.0 { (down_y / across, down_z / across) } else { (0.0, 1.0) };
    let secant = 1.0 / across.max(VERTICAL);
    let by_heading = Vector3::new(0.0, sin_roll * secant, cos_roll * secant);
    [Vector3::x() - by_heading * down_x, Vector3::new(0.0, cos_roll, -sin_roll), by_heading]
}

impl Sensor<3> for Tilt {
    fn observe<const N: usize>(&self, value: &[f64; 3], motion: &Kinematics<N>) -> Observation<N> {
        let [roll, pitch] = tilt(&motion.rotation);
        let by_turn = euler_by_turn(&motion.rotation);
        let mut o = Observation::empty(2);
        (o.innovation[0], o.innovation[1]) = (wrap(value[0] - roll), value[1] - pitch);
        for i in 0..2 {
            o.variance[i] = self.sigma * self.sigma;
            motion.turn.add_to(&mut o.rows[i], &by_turn[i]);
        }
        o
    }
}

impl Sensor<3> for Heading {
    fn observe<const N: usize>(&self, value: &[f64; 3], motion: &Kinematics<N>) -> Observation<N> {
        let [.., by_turn] = euler_by_turn(&motion.rotation);
        let mut o = Observation::empty(1);
        motion.turn.add_to(&mut o.rows[0], &by_turn);
        if let Some(state) = motion.sensors.heading_bias {
            o.rows[0][state] = 1.0;
        }
        let predicted = heading(&motion.rotation) + motion.optional(motion.sensors.heading_bias);
        o.innovation[0] = wrap(value[2] - predicted);
        o.variance[0] = self.sigma * self.sigma;
        o
    }
}
