//! The estimate: the motion according to a filter, and how far it can be trusted.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::belief::Belief;
use super::interval::Interval;
use super::kinematics::{Kinematics, Linearized, Motion, skew};
use super::process::Process;
use super::sensor::{euler, euler_by_turn};
use super::track::{CHANNELS, Setup};

/// Health of a filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Health {
    /// Everything is as the filter expects.
    #[default]
    Good,
    /// The position error grows: no velocity, or no fix, for longer than a few samples.
    Starved,
    /// Measurements contradict the estimate more often than chance allows.
    Inconsistent,
    /// The estimate was lost and restarted from the start values with wide uncertainty.
    Diverged,
}

/// Statistics of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ChannelReport {
    /// Innovation of the newest measurement.
    pub innovation: [f64; 3],
    /// Its predicted standard deviation.
    pub sigma: [f64; 3],
    /// Its normalised innovation squared.
    pub nis: f64,
    /// Measurements fused.
    pub used: u32,
    /// Measurements limited as outliers, or rejected as invalid.
    pub rejected: u32,
    /// Measurements that came late: inserted at their instant, or lost if that is too far back.
    pub late: u32,
}

/// The estimate at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Position, NED (m).
    pub position: [f64; 3],
    /// Roll, pitch, yaw (rad).
    pub euler: [f64; 3],
    /// Velocity over ground, body (m/s).
    pub velocity: [f64; 3],
    /// Angular rate, body (rad/s).
    pub rate: [f64; 3],
    /// Time derivative of `velocity` (m/s2).
    pub acceleration: [f64; 3],
    /// Current north and east (m/s); zero where the filter has none.
    pub current: [f64; 2],
    /// Covariance of x, y, z, roll, pitch, yaw (m, rad).
    pub covariance: [[f64; 6]; 6],
    /// Standard deviations of the velocity (m/s).
    pub velocity_sigma: [f64; 3],
    /// Tilt, heading, depth, velocity log, fix.
    pub channels: [ChannelReport; CHANNELS],
    /// State of health.
    pub health: Health,
    /// Estimated share of its thrust that each thruster has lost.
    pub loss: [f64; 8],
}

/// The parts of an estimate that depend only on the belief: how far it can be trusted, and the
/// current.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Spread {
    covariance: [[f64; 6]; 6],
    velocity_sigma: [f64; 3],
    current: [f64; 2],
}

impl Spread {
    /// For the pose `lag` seconds later.
    pub(super) fn of<P: Process<N>, const N: usize>(
        setup: &Setup<P>,
        belief: &Belief<N>,
        motion: &Kinematics<N>,
        lag: f64,
    ) -> Self {
        let mut position = Linearized::<3>::constant(motion.position.value);
        position.add(&Matrix3::identity(), &motion.position);
        if lag > setup.parameters.interval {
            // It moves with the velocity, like a point of the body ahead.
            let ahead = motion.velocity.value * lag;
            position.add_block(&motion.turn.through(&-(motion.rotation * skew(&ahead))));
            position.add(&(motion.rotation * lag), &motion.velocity);
        }
        let mut attitude = Linearized::<1>::constant(Vector3::zeros());
        let by_turn = Matrix3::from_columns(&euler_by_turn(&motion.rotation)).transpose();
        attitude.add_block(&motion.turn.through(&by_turn));

        let p = &belief.covariance;
        let mut covariance = [[0.0; 6]; 6];
        let mut set = |(i, j): (usize, usize), by: &Matrix3<f64>| {
            for k in 0..3 {
                for l in 0..3 {
                    // Symmetric to the last bit.
                    if i + k >= j + l {
                        covariance[i + k][j + l] = by[(k, l)];
                        covariance[j + l][i + k] = by[(k, l)];
                    }
                }
            }
        };
        set((0, 0), &position.covariance(&position, p));
        set((3, 0), &attitude.covariance(&position, p));
        set((3, 3), &attitude.covariance(&attitude, p));
        if setup.process.tilt_is_input() {
            let sigma = setup.parameters.sensors.tilt_sigma;
            (3..5).for_each(|i| covariance[i][i] = sigma * sigma);
        }
        // A velocity log has treated the error of the rate as an error of the velocity.
        let arms = skew(&Vector3::from(setup.parameters.mounting.dvl));
        let velocity = motion.velocity.covariance(&motion.velocity, p);
        let mut velocity_sigma = [0.0; 3];
        for (i, sigma) in velocity_sigma.iter_mut().enumerate() {
            let by_rate = arms.row(i).norm_squared() * motion.tracking_variance;
            *sigma = (velocity[(i, i)].max(0.0) + by_rate).sqrt();
        }
        let current =
            setup.process.current().map_or([0.0; 2], |states| states.map(|i| belief.mean[i]));
        Self { covariance, velocity_sigma, current }
    }
}

/// The motion according to a belief.
pub(super) fn describe<P: Process<N>, const N: usize>(
    setup: &Setup<P>,
    belief: &Belief<N>,
    interval: &Interval,
) -> Estimate {
    let process = &setup.process;
    let spread = Spread::of(setup, belief, &process.kinematics(belief, interval), 0.0);
    estimate(&process.motion(belief, interval), &spread)
}

/// An estimate without channels and thrusters.
#[inline(always)]
pub(super) fn estimate(motion: &Motion, spread: &Spread) -> Estimate {
    let Spread { covariance, velocity_sigma, current } = *spread;
    Estimate {
        position: motion.position.into(),
        euler: euler(&motion.rotation),
        velocity: motion.velocity.into(),
        rate: motion.rate.into(),
        acceleration: motion.acceleration.into(),
        covariance,
        velocity_sigma,
        current,
        ..Estimate::default()
    }
}
