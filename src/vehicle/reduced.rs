//! The reduced model of four degrees of freedom (surge, sway, heave, yaw), level trim, no current.
//!
//! Eqs (27)-(30) of the paper with corrected signs (a: added mass, d: damping, both positive):
//! ```text
//! (m + a11) u' = -(dl1 + dq1|u|) u + (m + a22) v r + X
//! (m + a22) v' = -(dl2 + dq2|v|) v - (m + a11) u r + Y
//! (m + a33) w' = -(dl3 + dq3|w|) w + (W - B) + Z
//! (I + a66) r' = -(dl6 + dq6|r|) r - (a22 - a11) u v + N
//! ```

use super::Parameters;
use crate::ParameterError;

/// The reduced model, with its constants derived and checked.
#[derive(Clone, Debug, PartialEq)]
pub struct ReducedModel {
    /// Mass or inertia including added mass, for surge, sway, heave, yaw.
    inertia: [f64; 4],
    linear_damping: [f64; 4],
    quadratic_damping: [f64; 4],
    munk: f64,
    excess_weight: f64,
    /// Surge, sway, heave and yaw of one newton of each thruster.
    thruster_wrench: [[f64; 4]; 8],
}

impl ReducedModel {
    /// Takes the values it needs from the full set: the diagonal of M_A.
    ///
    /// # Errors
    /// As [`super::Vehicle::new`].
    pub fn new(parameters: &Parameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let a = &parameters.added_mass;
        let pick = |d: &[f64; 6]| [d[0], d[1], d[2], d[5]];
        let m = parameters.mass;
        Ok(Self {
            inertia: [m + a[0][0], m + a[1][1], m + a[2][2], parameters.inertia.zz + a[5][5]],
            linear_damping: pick(&parameters.linear_damping),
            quadratic_damping: pick(&parameters.quadratic_damping),
            munk: a[1][1] - a[0][0],
            excess_weight: parameters.weight() - parameters.buoyancy_force(),
            thruster_wrench: parameters.propulsion.thrusters.map(|t| pick(&t.unit_wrench())),
        })
    }

    /// Time derivative of `velocity` = [u, v, w, r] (body) under eight thrusts (N).
    #[must_use]
    pub fn acceleration(&self, velocity: [f64; 4], thrust: &[f64; 8]) -> [f64; 4] {
        let [u, v, _, r] = velocity;
        let m = &self.inertia;
        let mut force = [m[1] * v * r, -m[0] * u * r, self.excess_weight, -self.munk * u * v];
        for (column, t) in self.thruster_wrench.iter().zip(thrust) {
            for i in 0..4 {
                force[i] += column[i] * t;
            }
        }
        core::array::from_fn(|i| {
            let damping = self.linear_damping[i] + self.quadratic_damping[i] * velocity[i].abs();
            (force[i] - damping * velocity[i]) / m[i]
        })
    }
}
