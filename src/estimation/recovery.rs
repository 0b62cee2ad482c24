//! Additions to the Kalman update: the filter recovers when measurements contradict it but agree
//! with each other, and learns nothing about unobservable states.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::belief::{Belief, Row};
use super::kinematics::Kinematics;
use super::sensor::Observation;
use super::track::Channel;
use super::transition::Transition;

/// Consecutive limited measurements whose innovations agree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Agreement {
    count: u32,
    first: [f64; 3],
}

/// How many have to agree: position and depth are slow and have frequent outliers, and a compass in
/// a disturbed field stays wrong for long.
fn needed(channel: Channel) -> u32 {
    match channel {
        Channel::Fix => 5,
        Channel::Dvl | Channel::Depth => 10,
        Channel::Heading | Channel::Tilt => 25,
    }
}

/// Largest difference between two agreeing innovations, in standard deviations of the noise.
const WIDTH: f64 = 3.0 * core::f64::consts::SQRT_2;

impl Agreement {
    /// Takes the next measurement; returns whether enough have agreed.
    pub(super) fn hear<const N: usize>(
        &mut self,
        channel: Channel,
        observation: &Observation<N>,
        limited: bool,
    ) -> bool {
        if !limited {
            *self = Self::default();
            return false;
        }
        let agrees = (0..observation.size).all(|i| {
            let difference = observation.innovation[i] - self.first[i];
            difference.abs() <= WIDTH * observation.variance[i].sqrt()
        });
        if self.count > 0 && agrees {
            self.count += 1;
        } else {
            *self = Self { count: 1, first: observation.innovation };
        }
        self.count >= needed(channel)
    }
}

/// Discards the belief about the measured states; returns what happened to the errors.
pub(super) fn reacquire<const N: usize>(
    belief: &mut Belief<N>,
    channel: Channel,
    velocity: usize,
    observation: &Observation<N>,
) -> Transition<N> {
    let mut f = Transition::identity();
    let square = |x: f64| x * x;
    let far = |least: f64| {
        observation
            .innovation
            .iter()
            .take(observation.size)
            .fold(square(least), |m, y| m.max(y * y))
    };
    let mut forget = |state: usize, variance: f64| {
        belief.decouple(state, variance);
        f.scale(state, 0.0);
    };
    match channel {
        Channel::Fix => (0..2).for_each(|i| forget(i, far(20.0))),
        Channel::Depth => forget(2, far(5.0)),
        Channel::Dvl => (0..3).for_each(|i| forget(velocity + i, far(1.0))),
        // The attitude: increased along the directions that the measurement observes.
        Channel::Heading | Channel::Tilt => {
            for row in observation.rows.iter().take(observation.size) {
                for (state, h) in row.iter() {
                    if h.abs() > 0.1 {
                        forget(state, far(0.2));
                    }
                }
            }
        }
    }
    f
}

/// A magnetic step: the heading is unchanged, the bias of the compass is new, and known as well as
/// heading and compass are. Returns what happened to the errors.
pub(super) fn hand_to_bias<const N: usize>(
    belief: &mut Belief<N>,
    motion: &Kinematics<N>,
    observation: &Observation<N>,
) -> Transition<N> {
    let mut f = Transition::identity();
    let Some(bias) = motion.sensors.heading_bias else { return f };
    let mut row = observation.rows[0];
    row[bias] = 0.0;
    belief.decouple(bias, 0.0);
    let correlation = belief.correlate(&row);
    let variance = row.dot(&correlation) + observation.variance[0];
    for j in 0..belief.order() {
        belief.covariance[(bias, j)] = -correlation[j];
        belief.covariance[(j, bias)] = -correlation[j];
    }
    belief.covariance[(bias, bias)] = variance;
    belief.mean[bias] += observation.innovation[0];
    f.set_row(bias, row.iter().map(|(state, h)| (state, -h)));
    f
}

/// Velocity errors that hide one unit of each state that a velocity log cannot distinguish from a
/// change of the velocity (its scale, yaw, delay); `rows` is its Jacobian.
pub(super) type Hidden = [Vector3<f64>; 3];

pub(super) fn hidden<const N: usize>(
    velocity: usize,
    rows: &[Row<N>; 3],
    states: &[Option<usize>; 3],
) -> Option<Hidden> {
    let inverse = Matrix3::from_fn(|i, k| rows[i][velocity + k]).try_inverse()?;
    let by = |j: usize| -(inverse * Vector3::from_fn(|i, _| rows[i][j]));
    Some(states.map(|state| state.map_or(Vector3::zeros(), by)))
}

/// Keeps a covariance consistent with what a velocity log cannot observe by itself.
///
/// An error of its scale (or yaw) and the velocity error that hides it always occur in the same
/// ratio, which is that of the velocity itself. A correction of the velocity changes the ratio, and
/// so does a new angular rate through the lever arm. Without this step, the next measurement would
/// mistake the difference for information about the scale, and the noise of the rate for a scale
/// error. Huang, Mourikis & Roumeliotis (2010) constrain a filter's observability in this way.
pub(super) fn follow_unobservable<const N: usize>(
    velocity: usize,
    [before, after]: [&Hidden; 2],
    states: &[Option<usize>; 3],
) -> Transition<N> {
    let mut f = Transition::identity();
    for i in 0..3 {
        let own = core::iter::once((velocity + i, 1.0));
        let shift = |k: usize| states[k].map(|state| (state, after[k][i] - before[k][i]));
        f.set_row(velocity + i, own.chain((0..3).filter_map(shift)));
    }
    f
}
