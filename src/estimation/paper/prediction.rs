//! Prediction of the pose and of its covariance.
//!
//! Eq (36) with the rotation it lacks: `p+ = p + R(psi) [v dt + (v' + r z x v) dt^2 / 2]`,
//! `psi+ = psi + r dt + r' dt^2 / 2`; v and v' in the body frame. `P+ = F P F^T + Q`.

use super::{EkfParameters, ProcessNoise, Transition};
use crate::attitude;
use crate::vector::{Vec3, add, cross, sub};
use crate::vehicle::ReducedModel;
use serde::{Deserialize, Serialize};

/// Where the acceleration of the prediction comes from.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "one per filter; a box would gain nothing")]
pub enum Acceleration {
    /// Eqs (27)-(30) at the measured velocity and thrusts.
    Dynamic(ReducedModel),
    /// Specific force of the IMU less gravity.
    Kinematic,
}

/// Velocities and accelerations that a cycle predicts with, body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Motion {
    /// `[u, v, w, r]`.
    pub(super) velocity: [f64; 4],
    /// Their time derivatives.
    pub(super) acceleration: [f64; 4],
}

/// Bound of the paper's F, whose quotient is singular at rest.
const F_LIMIT: f64 = 1e3;
/// Variances stop growing here: the position is unknown anyway, and stays finite without fixes.
const VARIANCE_LIMIT: f64 = 1e12;

/// Time derivatives of u, v, w from the accelerometers.
///
/// The Euler term of a lever arm is left out: differencing the gyros would add more than it takes.
pub(super) fn inertial_acceleration(
    p: &EkfParameters,
    specific_force: Vec3,
    rate: Vec3,
    euler: Vec3,
    velocity: Vec3,
) -> Vec3 {
    let down = attitude::rotation_euler([euler[0], euler[1], 0.0])[2];
    let centripetal = cross(rate, cross(rate, p.imu_position));
    let gravity = down.map(|d| d * p.gravity);
    let inertial = add(sub(specific_force, centripetal), gravity);
    sub(inertial, cross([0.0, 0.0, rate[2]], velocity))
}

/// The pose a cycle later.
pub(super) fn predict_pose(p: &EkfParameters, pose: [f64; 4], motion: &Motion) -> [f64; 4] {
    let dt = 1.0 / p.rate_hz;
    let d = displacement(p, pose[3], motion);
    let (r, r_dot) = (motion.velocity[3], motion.acceleration[3]);
    [
        pose[0] + d[0],
        pose[1] + d[1],
        pose[2] + d[2],
        attitude::wrap(pose[3] + r * dt + 0.5 * r_dot * dt * dt),
    ]
}

/// Second derivative of the position along body axes, `v' + r z x v`, and of psi.
fn total_acceleration(motion: &Motion) -> [f64; 4] {
    let [u, v, _, r] = motion.velocity;
    let a = motion.acceleration;
    [a[0] - r * v, a[1] + r * u, a[2], a[3]]
}

/// Displacement of the position in a cycle, NED (m).
fn displacement(p: &EkfParameters, yaw: f64, motion: &Motion) -> Vec3 {
    let dt = 1.0 / p.rate_hz;
    let [u, v, w, _] = motion.velocity;
    let a = motion.acceleration;
    let down = w * dt + 0.5 * a[2] * dt * dt;
    if !p.rotate_to_ned {
        // As printed: body velocity and acceleration added to an NED position.
        return [u * dt + 0.5 * a[0] * dt * dt, v * dt + 0.5 * a[1] * dt * dt, down];
    }
    let total = total_acceleration(motion);
    let along = u * dt + 0.5 * total[0] * dt * dt;
    let across = v * dt + 0.5 * total[1] * dt * dt;
    let (sin, cos) = libm::sincos(yaw);
    [cos * along - sin * across, sin * along + cos * across, down]
}

/// The covariance a cycle later; `before` is the motion of the previous cycle.
pub(super) fn predict_covariance(
    p: &EkfParameters,
    covariance: &[[f64; 4]; 4],
    yaw: f64,
    motion: &Motion,
    before: &Motion,
) -> [[f64; 4]; 4] {
    let f = transition(p, yaw, motion, before);
    let q = process_variance(p);
    let mut predicted = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..=i {
            let mut sum = if i == j { q[i] } else { 0.0 };
            for k in 0..4 {
                for l in 0..4 {
                    sum += f[i][k] * covariance[k][l] * f[j][l];
                }
            }
            predicted[i][j] = sum;
            predicted[j][i] = sum;
        }
    }
    limit(predicted)
}

fn transition(p: &EkfParameters, yaw: f64, motion: &Motion, before: &Motion) -> [[f64; 4]; 4] {
    let mut f = [[0.0; 4]; 4];
    let (now, before) = (total_acceleration(motion), total_acceleration(before));
    for i in 0..4 {
        let v = motion.velocity[i];
        let quotient = 1.0 + (now[i] + 0.5 * (now[i] - before[i])) / (v * p.rate_hz);
        f[i][i] = match p.transition {
            Transition::Repaired => 1.0,
            Transition::Paper if v.abs() < p.guard_speed => 1.0,
            // At v = 0 with no acceleration the quotient 0/0 says nothing.
            _ if quotient.is_nan() => 1.0,
            _ => quotient.clamp(-F_LIMIT, F_LIMIT),
        };
    }
    if p.transition == Transition::Repaired && p.rotate_to_ned {
        let d = displacement(p, yaw, motion);
        f[0][3] = -d[1];
        f[1][3] = d[0];
    }
    f
}

fn process_variance(p: &EkfParameters) -> [f64; 4] {
    match p.process_noise {
        ProcessNoise::Constant => p.process_variance,
        ProcessNoise::Dvl => {
            let walk = p.dvl_sigma * p.dvl_sigma / (p.rate_hz * p.dvl_rate_hz);
            [walk, walk, walk, p.process_variance[3]]
        }
    }
}

/// Scales rows and columns whose variance passed the limit, which keeps P positive definite.
fn limit(mut covariance: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    for i in 0..4 {
        if covariance[i][i] > VARIANCE_LIMIT {
            let scale = (VARIANCE_LIMIT / covariance[i][i]).sqrt();
            for j in 0..4 {
                covariance[i][j] *= scale;
                covariance[j][i] *= scale;
            }
        }
    }
    covariance
}
