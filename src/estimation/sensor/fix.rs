//! Horizontal position fix (GPS at the surface, USBL or LBL below): `(p + R l)_{x,y}`.

use nalgebra::Vector3;

use super::{Observation, Sensor};
use crate::estimation::kinematics::Kinematics;

/// Smallest standard deviation that a fix may report (m).
const LEAST: f64 = 1e-3;

/// North and east of the antenna or transponder, and the standard deviation reported with them (m);
/// 0: not reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Position, body (m).
    pub lever: Vector3<f64>,
    /// Standard deviation of each axis if none is reported (m).
    pub sigma: f64,
}

impl Sensor<3> for Fix {
    fn observe<const N: usize>(
        &self,
        &[north, east, reported]: &[f64; 3],
        motion: &Kinematics<N>,
    ) -> Observation<N> {
        let point = motion.point(&self.lever);
        let sigma = if reported > 0.0 { reported.max(LEAST) } else { self.sigma };
        let mut o = Observation::empty(2);
        (o.innovation[0], o.innovation[1]) = (north - point.x, east - point.y);
        for i in 0..2 {
            o.variance[i] = sigma * sigma;
            motion.add_point_to(&mut o.rows[i], &self.lever, i);
        }
        o
    }
}
