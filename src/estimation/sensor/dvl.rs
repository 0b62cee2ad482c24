//! Doppler velocity log: velocity over ground at its position, along its axes.
//!
//! `y = (1 + s) Rz(m)^T (v + omega x l - tau v')`: scale error s, misalignment m in yaw, and delay
//! tau of its clock relative to that of the attitude, if they are states. Hegrenæs & Berglund
//! (2009) for the error model.

use nalgebra::{Matrix3, Vector3};

use super::{Observation, Sensor};
use crate::estimation::kinematics::{Kinematics, skew};

/// Velocity at the instrument (m/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dvl {
    /// Position, body (m).
    pub lever: Vector3<f64>,
    /// Standard deviation of each axis (m/s).
    pub sigma: f64,
}

impl Sensor<3> for Dvl {
    fn observe<const N: usize>(&self, value: &[f64; 3], motion: &Kinematics<N>) -> Observation<N> {
        let states = &motion.sensors;
        let scale = 1.0 + motion.optional(states.dvl_scale);
        let delay = motion.optional(states.dvl_delay);
        let (sin, cos) = libm::sincos(motion.optional(states.dvl_misalignment));
        let turn = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);

        let lever = motion.rate.value.cross(&self.lever);
        let at_instrument = motion.velocity.value + lever - motion.acceleration.value * delay;
        let aligned = turn * at_instrument;
        let through_velocity = turn * scale;
        let through_rate = -through_velocity * skew(&self.lever);
        let mut o = Observation::empty(3);
        for (i, row) in o.rows.iter_mut().enumerate() {
            let by_velocity = through_velocity.row(i).transpose();
            motion.velocity.add_to(row, &by_velocity);
            motion.rate.add_to(row, &through_rate.row(i).transpose());
            if states.dvl_delay.is_some() {
                motion.acceleration.add_to(row, &(by_velocity * -delay));
            }
        }
        let by_misalignment = Vector3::new(aligned.y, -aligned.x, 0.0) * scale;
        let by_delay = -(through_velocity * motion.acceleration.value);
        for (i, row) in o.rows.iter_mut().enumerate() {
            for (state, derivative) in [
                (states.dvl_scale, aligned[i]),
                (states.dvl_misalignment, by_misalignment[i]),
                (states.dvl_delay, by_delay[i]),
            ] {
                if let Some(state) = state {
                    row[state] = derivative;
                }
            }
        }
        // The rate's own noise acts through the lever arm, equally on the axes across it.
        let predicted = aligned * scale;
        for i in 0..3 {
            let arm = through_rate.row(i).norm_squared();
            o.innovation[i] = value[i] - predicted[i];
            o.variance[i] = self.sigma * self.sigma + arm * motion.rate_variance;
        }
        o
    }
}
