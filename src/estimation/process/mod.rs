//! Processes: how a state evolves between measurements.

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

    /// Pseudo-measurements of the interval itself, together with the previous one: balances of
    /// force and moment, a gyro compared with a modelled rate.
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

    /// Uses an attitude `[roll, pitch, yaw]` (rad) as the mean.
    fn align(&self, belief: &mut Belief<N>, euler: [f64; 3]);

    /// The first of three velocity states; the position is always states 0 to 2.
    fn velocity(&self) -> usize;

    /// The states of the current north and east, if there are any.
    fn current(&self) -> Option<[usize; 2]> {
        None
    }

    /// Effect of one newton of thruster `i` on the states per second.
    fn thrust_effect(&self, i: usize) -> Column<N> {
        let _ = i;
        Column::zeros()
    }

    /// Whether only the velocity log shows how the velocity changes during an interval.
    fn coasts(&self, interval: &Interval) -> bool {
        interval.inertial.is_none() && !(self.uses_thrust() && interval.thrust.is_some())
    }

    /// Whether the process uses thrusts.
    fn uses_thrust(&self) -> bool {
        false
    }

    /// Whether roll and pitch are used as measured, and only the heading is a state.
    fn tilt_is_input(&self) -> bool {
        false
    }
}
