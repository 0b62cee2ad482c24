//! Prediction of the pose and of its covariance.
//!
//! Eq (36) with the rotation it lacks: `p+ = p + R(psi) [v dt + (v' + r z x v) dt^2 / 2]`,
//! `psi+ = psi + r dt + r' dt^2 / 2`; v and v' in the body frame. `P+ = F P F^T + Q`.

use nalgebra::{Matrix4, Vector4};
use serde::{Deserialize, Serialize};

use super::{EkfParameters, ProcessNoise};
use crate::attitude;
use crate::estimation::Belief;
use crate::vector::{Vec3, add, cross, sub};
use crate::vehicle::ReducedModel;

/// Source of the acceleration for the prediction.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "one per filter; a box would gain nothing")]
pub enum Acceleration {
    /// Eqs (27)-(30) at the measured velocity and thrusts.
    Dynamic(ReducedModel),
    /// Specific force of the IMU minus gravity.
    Kinematic,
}

/// Velocities and accelerations for the prediction of a cycle, body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Motion {
    /// `[u, v, w, r]`.
    pub(super) velocity: [f64; 4],
    /// Their time derivatives.
    pub(super) acceleration: [f64; 4],
}

impl Motion {
    /// Second derivative of the position along body axes, `v' + r z x v`, and of psi.
    pub(super) fn total_acceleration(&self) -> [f64; 4] {
        let [u, v, _, r] = self.velocity;
        let a = self.acceleration;
        [a[0] - r * v, a[1] + r * u, a[2], a[3]]
    }

    pub(super) fn is_finite(&self) -> bool {
        self.velocity.iter().chain(&self.acceleration).all(|x| x.is_finite())
    }
}

/// Time derivatives of u, v, w from the accelerometers.
///
/// The Euler term of a lever arm is omitted: differencing the gyros would add more noise than it
/// removes error.
pub(super) fn inertial_acceleration(
    p: &EkfParameters,
    specific_force: Vec3,
    rate: Vec3,
    tilt: [f64; 2],
    velocity: Vec3,
) -> Vec3 {
    let down = attitude::rotation_euler([tilt[0], tilt[1], 0.0])[2];
    let centripetal = cross(rate, cross(rate, p.mounting.imu));
    let gravity = down.map(|d| d * p.gravity);
    let inertial = add(sub(specific_force, centripetal), gravity);
    sub(inertial, cross([0.0, 0.0, rate[2]], velocity))
}

/// The belief one cycle later; `before` is the motion of the previous cycle.
pub(super) fn predict(p: &EkfParameters, belief: &mut Belief<4>, motion: &Motion, before: &Motion) {
    let dt = 1.0 / p.rate_hz;
    let d = displacement(p, belief.mean[3], motion, dt);
    let cov = &mut belief.covariance;
    match p.misprinted() {
        Some(f) => {
            let f = f.diagonal(motion, before, dt);
            *cov = Matrix4::from_fn(|i, j| f[i] * cov[(i, j)] * f[j]);
        }
        None if p.rotate_to_ned => {
            // The derivative of the prediction is the identity, but for a displacement that rotates
            // with psi.
            let f = [-d[1], d[0]];
            (0..4).for_each(|j| (0..2).for_each(|i| cov[(i, j)] += f[i] * cov[(3, j)]));
            (0..4).for_each(|j| (0..2).for_each(|i| cov[(j, i)] += f[i] * cov[(j, 3)]));
        }
        None => {}
    }
    for (state, variance) in process_variance(p, dt).into_iter().enumerate() {
        belief.add_noise(state, variance);
    }
    belief.confine();
    let (r, r_dot) = (motion.velocity[3], motion.acceleration[3]);
    belief.mean += Vector4::new(d[0], d[1], d[2], r * dt + 0.5 * r_dot * dt * dt);
    belief.mean[3] = attitude::wrap(belief.mean[3]);
}

/// Displacement of the position in a cycle, NED (m).
fn displacement(p: &EkfParameters, yaw: f64, motion: &Motion, dt: f64) -> Vec3 {
    let [u, v, w, _] = motion.velocity;
    let a = motion.acceleration;
    let down = w * dt + 0.5 * a[2] * dt * dt;
    if !p.rotate_to_ned {
        // As printed: body velocity and acceleration added to an NED position.
        return [u * dt + 0.5 * a[0] * dt * dt, v * dt + 0.5 * a[1] * dt * dt, down];
    }
    let total = motion.total_acceleration();
    let along = u * dt + 0.5 * total[0] * dt * dt;
    let across = v * dt + 0.5 * total[1] * dt * dt;
    let (sin, cos) = libm::sincos(yaw);
    [cos * along - sin * across, sin * along + cos * across, down]
}

fn process_variance(p: &EkfParameters, dt: f64) -> [f64; 4] {
    match p.process_noise {
        ProcessNoise::Constant => p.process_variance,
        ProcessNoise::Dvl => {
            let walk = p.dvl_sigma * p.dvl_sigma * dt / p.dvl_rate_hz;
            [walk, walk, walk, p.process_variance[3]]
        }
    }
}
