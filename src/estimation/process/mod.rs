//! Processes: how a state moves between measurements.

pub(crate) mod rotation;

pub mod constant_acceleration;
pub mod inertial;
pub mod model_aid;
pub mod planar_dynamic;

use super::belief::{Belief, Column};
use super::interval::Interval;
use super::kalman::Witness;
use super::kinematics::{Kinematics, Motion};

/// A model of motion with at most `N` states.
pub trait Process<const N: usize> {
    /// The belief at the start.
    fn initial(&self) -> Belief<N>;

    /// Predicts over an interval: mean and covariance.
    fn predict(&self, belief: &mut Belief<N>, interval: &Interval, witness: &mut impl Witness<N>);

    /// Measurements that the interval itself makes, with the one before it: balances of force and
    /// moment, a gyro compared with a modelled rate.
    fn aid(
        &self,
        belief: &mut Belief<N>,
        before: &Interval,
        interval: &Interval,
        witness: &mut impl Witness<N>,
    ) {
        let _ = (belief, before, interval, witness);
    }

    /// The motion at the end of an interval.
    fn motion(&self, belief: &Belief<N>, interval: &Interval) -> Motion;

    /// The same with its derivatives.
    fn kinematics(&self, belief: &Belief<N>, interval: &Interval) -> Kinematics<N>;

    /// Adds a correction to the mean.
    fn correct(&self, belief: &mut Belief<N>, correction: &Column<N>);

    /// Takes an attitude `[roll, pitch, yaw]` (rad) for the mean.
    fn align(&self, belief: &mut Belief<N>, euler: [f64; 3]);

    /// The first of three states of the velocity; the position is always states 0 to 2.
    fn velocity(&self) -> usize;

    /// The states of the current north and east, where there are any.
    fn current(&self) -> Option<[usize; 2]> {
        None
    }

    /// Change of the states in a second that a newton of thruster `i` makes.
    fn thrust_effect(&self, i: usize) -> Column<N> {
        let _ = i;
        Column::zeros()
    }

    /// Whether nothing but the velocity log says how the velocity changes during an interval.
    fn coasts(&self, interval: &Interval) -> bool {
        interval.inertial.is_none() && !(self.uses_thrust() && interval.thrust.is_some())
    }

    /// Whether the process makes use of thrusts.
    fn uses_thrust(&self) -> bool {
        false
    }

    /// Whether roll and pitch are taken from their sensor as they are, and only the heading is a state.
    fn tilt_is_input(&self) -> bool {
        false
    }
}
