//! The transition matrix of the covariance as the paper prints it, eqs (44)-(47).
//!
//! `F_ii = 1 + (a + da/2) dt / v` with `a = v' + r z x v` and `da` its change since the previous
//! cycle: a quotient of displacements instead of the derivative of the prediction. It is singular
//! at rest, and heading and position are independent in it.

use nalgebra::Vector4;

use super::prediction::Motion;

/// Bound of the quotients.
const LIMIT: f64 = 1e3;

/// Eqs (44)-(47), kept finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Misprinted {
    /// Speed (m/s, rad/s) below which a quotient is 1.
    pub(super) guard_speed: f64,
}

impl Misprinted {
    /// The diagonal F of a cycle of `dt` seconds; `before` is the motion of the previous cycle.
    pub(super) fn diagonal(&self, motion: &Motion, before: &Motion, dt: f64) -> Vector4<f64> {
        let (now, before) = (motion.total_acceleration(), before.total_acceleration());
        Vector4::from_fn(|i, _| {
            let v = motion.velocity[i];
            let quotient = 1.0 + (now[i] + 0.5 * (now[i] - before[i])) / v * dt;
            // At v = 0 without acceleration the quotient is 0/0.
            if v.abs() < self.guard_speed || quotient.is_nan() {
                1.0
            } else {
                quotient.clamp(-LIMIT, LIMIT)
            }
        })
    }
}
