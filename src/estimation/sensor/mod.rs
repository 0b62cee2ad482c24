//! Sensors as a filter sees them: innovation, Jacobian and noise of a measurement.

mod ahrs;
mod depth;
mod dvl;
mod fix;

use super::belief::Row;
use super::kinematics::Kinematics;

pub use ahrs::{Heading, Tilt, euler, euler_by_turn};
pub use depth::Depth;
pub use dvl::Dvl;
pub use fix::Fix;

/// A measurement compared with its prediction: up to three components with independent noise.
#[derive(Clone, Copy, Debug)]
pub struct Observation<const N: usize> {
    /// How many components.
    pub size: usize,
    /// Measured minus predicted.
    pub innovation: [f64; 3],
    /// Derivatives of the prediction by the states.
    pub rows: [Row<N>; 3],
    /// Variances of the noise.
    pub variance: [f64; 3],
}

impl<const N: usize> Observation<N> {
    /// With `size` components that do not depend on any state, with no innovation and unit
    /// variance, to be filled in.
    #[must_use]
    #[inline(always)]
    pub(super) fn empty(size: usize) -> Self {
        Self { size, innovation: [0.0; 3], rows: Row::NONE, variance: [1.0; 3] }
    }

    /// With the first `size` components.
    #[must_use]
    pub fn new(size: usize, innovation: [f64; 3], rows: [Row<N>; 3], variance: [f64; 3]) -> Self {
        Self { size, innovation, rows, variance }
    }

    /// With one component.
    #[must_use]
    pub fn scalar(innovation: f64, row: Row<N>, variance: f64) -> Self {
        let mut o = Self::empty(1);
        (o.innovation[0], o.rows[0], o.variance[0]) = (innovation, row, variance);
        o
    }
}

/// A sensor: compares its measurement, `value`, with the prediction from the motion.
pub trait Sensor<const K: usize> {
    /// The comparison.
    fn observe<const N: usize>(&self, value: &[f64; K], motion: &Kinematics<N>) -> Observation<N>;
}
