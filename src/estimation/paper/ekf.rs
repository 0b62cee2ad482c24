//! One cycle of the filter: predict, then update with what has been measured since.
//!
//! H = I, so each measurement is one component of the state; with a diagonal R they are fused one
//! after the other, which equals eqs (50)-(53) in one go. The update has Joseph's form, equal to
//! eq (53) and symmetric and positive whatever the rounding.

use super::prediction::{Motion, inertial_acceleration, predict_covariance, predict_pose};
use super::{Acceleration, EkfParameters, EstimationError, Measurements};
use crate::ParameterError;
use crate::attitude;
use crate::sampling::Rate;
use crate::vector::{cross, mul, sub};
use serde::{Deserialize, Serialize};

/// What the filter remembers between cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EkfMemory {
    pose: [f64; 4],
    covariance: [[f64; 4]; 4],
    motion: Motion,
    /// Roll and pitch last measured (rad).
    tilt: [f64; 2],
    /// Times of the newest readings of IMU, DVL, fix and pressure (s).
    seen: [f64; 4],
    /// False until the first cycle, which does not predict.
    running: bool,
}

/// What the filter knows after a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// `[x, y, z, yaw]`, NED (m, rad).
    pub pose: [f64; 4],
    /// `[u, v, w, r]` at the centre of gravity, body, as measured (m/s, rad/s).
    pub velocity: [f64; 4],
    /// Their time derivatives as used in the prediction.
    pub acceleration: [f64; 4],
    /// Standard deviations of `pose`.
    pub sigma: [f64; 4],
    /// Covariance of x and y (m2).
    pub covariance_xy: f64,
}

/// A filter, its parameters checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Ekf {
    /// How often it runs.
    pub rate: Rate,
    parameters: EkfParameters,
    source: Acceleration,
}

impl Ekf {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(parameters: &EkfParameters, source: Acceleration) -> Result<Self, ParameterError> {
        parameters.check()?;
        let rate = Rate::new(parameters.rate_hz)?;
        Ok(Self { rate, parameters: *parameters, source })
    }

    /// The memory at the start.
    #[must_use]
    pub fn memory(&self) -> EkfMemory {
        let p = &self.parameters;
        let variance = p.initial_sigma.map(|s| s * s);
        let [x, y, z, yaw] = p.initial_pose;
        EkfMemory {
            pose: [x, y, z, attitude::wrap(yaw)],
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| if i == j { variance[i] } else { 0.0 })
            }),
            seen: [-1.0; 4],
            ..EkfMemory::default()
        }
    }

    /// One cycle; the first only updates.
    ///
    /// # Errors
    /// A measurement in use is not a finite number, or the state overflowed; the memory is then
    /// unchanged and the next cycle may be tried.
    pub fn update(
        &self,
        memory: &mut EkfMemory,
        measured: &Measurements,
    ) -> Result<Estimate, EstimationError> {
        measured.check(matches!(self.source, Acceleration::Dynamic(_)))?;
        let mut next = *memory;
        let imu_new = measured.imu.take_new(&mut next.seen[0]);
        let before = next.motion;
        self.observe_motion(&mut next, measured, imu_new);
        if next.running {
            let (p, yaw) = (&self.parameters, next.pose[3]);
            let motion = &next.motion;
            next.covariance = predict_covariance(p, &next.covariance, yaw, motion, &before);
            next.pose = predict_pose(p, next.pose, motion);
        }
        self.fuse_new(&mut next, measured, imu_new);
        next.running = true;
        if let Some(i) = next.pose.iter().position(|x| !x.is_finite()) {
            return Err(EstimationError {
                quantity: format!("estimated pose[{i}] (x, y, z, yaw)"),
                value: next.pose[i],
                reason: "the estimate overflowed; the measurements are far out of any range",
            });
        }
        *memory = next;
        Ok(self.estimate(memory))
    }

    /// What the filter knows, without a cycle.
    #[must_use]
    pub fn estimate(&self, memory: &EkfMemory) -> Estimate {
        Estimate {
            pose: memory.pose,
            velocity: memory.motion.velocity,
            acceleration: memory.motion.acceleration,
            sigma: core::array::from_fn(|i| memory.covariance[i][i].sqrt()),
            covariance_xy: memory.covariance[0][1],
        }
    }

    /// Velocity from DVL (moved to the centre of gravity) and gyro, acceleration from the source.
    /// Readings that are not valid leave the last values standing.
    fn observe_motion(&self, memory: &mut EkfMemory, measured: &Measurements, imu_new: bool) {
        let p = &self.parameters;
        let imu = &measured.imu.value;
        let before = memory.motion;
        if imu_new {
            memory.tilt = [imu.euler[0], imu.euler[1]];
            memory.motion.velocity[3] = imu.rate[2];
        }
        if measured.dvl.take_new(&mut memory.seen[1]) {
            // Four degrees of freedom: p and q are zero in the model, and a gyro's bias in them is
            // worth more than what it would correct.
            let yaw_rate = if measured.imu.valid { imu.rate[2] } else { 0.0 };
            let lever = cross([0.0, 0.0, yaw_rate], p.dvl_position);
            let v = sub(measured.dvl.value.velocity, lever);
            memory.motion.velocity[..3].copy_from_slice(&v);
        }
        let velocity = memory.motion.velocity;
        match &self.source {
            Acceleration::Dynamic(model) => {
                memory.motion.acceleration = model.acceleration(velocity, &measured.thrust);
            }
            Acceleration::Kinematic if imu_new => {
                let v = [velocity[0], velocity[1], velocity[2]];
                let a = inertial_acceleration(p, imu.specific_force, imu.rate, imu.euler, v);
                memory.motion.acceleration[..3].copy_from_slice(&a);
                let turned = if memory.running { velocity[3] - before.velocity[3] } else { 0.0 };
                memory.motion.acceleration[3] = turned * p.rate_hz;
            }
            Acceleration::Kinematic => {}
        }
    }

    fn fuse_new(&self, memory: &mut EkfMemory, measured: &Measurements, imu_new: bool) {
        let p = &self.parameters;
        let r_nb = attitude::rotation_euler([memory.tilt[0], memory.tilt[1], memory.pose[3]]);
        if measured.fix.take_new(&mut memory.seen[2]) {
            let lever = mul(&r_nb, p.fix_position);
            for i in 0..2 {
                let position = measured.fix.value.position[i] - lever[i];
                fuse(memory, i, position - memory.pose[i], p.fix_sigma);
            }
        }
        if measured.pressure.take_new(&mut memory.seen[3]) {
            let depth = measured.pressure.value - mul(&r_nb, p.pressure_position)[2];
            fuse(memory, 2, depth - memory.pose[2], p.depth_sigma);
        }
        if imu_new {
            let innovation = attitude::wrap(measured.imu.value.euler[2] - memory.pose[3]);
            fuse(memory, 3, innovation, p.heading_sigma);
            memory.pose[3] = attitude::wrap(memory.pose[3]);
        }
    }
}

/// Updates with a direct measurement of state component `i`.
fn fuse(memory: &mut EkfMemory, i: usize, innovation: f64, sigma: f64) {
    let p = memory.covariance;
    let variance = sigma * sigma;
    let gain: [f64; 4] = core::array::from_fn(|j| p[j][i] / (p[i][i] + variance));
    for (x, k) in memory.pose.iter_mut().zip(gain) {
        *x += k * innovation;
    }
    // Joseph: (I - K H) P (I - K H)^T + K R K^T, with H the i-th row of I.
    for a in 0..4 {
        for b in 0..=a {
            let cross_terms = gain[a] * p[i][b] + gain[b] * p[a][i];
            let joseph = p[a][b] - cross_terms + gain[a] * gain[b] * (p[i][i] + variance);
            memory.covariance[a][b] = joseph;
            memory.covariance[b][a] = joseph;
        }
    }
}
