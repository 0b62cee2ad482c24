//! Depth of the pressure sensor: `(p + R l)_z`.

use nalgebra::Vector3;

use super::{Observation, Sensor};
use crate::estimation::kinematics::Kinematics;

/// Depth at the sensor (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// Position, body (m).
    pub lever: Vector3<f64>,
    /// Standard deviation (m).
    pub sigma: f64,
}

impl Sensor<1> for Depth {
    fn observe<const N: usize>(
        &self,
        &[depth]: &[f64; 1],
        motion: &Kinematics<N>,
    ) -> Observation<N> {
        let mut o = Observation::empty(1);
        o.innovation[0] = depth - motion.point(&self.lever).z;
        o.variance[0] = self.sigma * self.sigma;
        motion.add_point_to(&mut o.rows[0], &self.lever, 2);
        o
    }
}
