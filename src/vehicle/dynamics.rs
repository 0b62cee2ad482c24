//! Right-hand side of the six-degree-of-freedom equations of motion.
//!
//! Fossen (2011) eq (6.43) ff., eqs (5)-(26) of the paper, in the momentum form of Kirchhoff (Fossen
//! 2011 ch. 6.3). With the body frame at the centre of gravity, c = R^T v_c and
//! `[p; h] = (M_RB + M_A) nu_r`, rigid body, added mass and their Coriolis terms are together
//!
//! ```text
//! M nu_r' = tau - g - (D_l + D_q |nu_r|) nu_r - [omega x p; omega x h + v_r x p]
//! nu'     = nu_r' - [omega x c; 0]
//! ```
//! This is the equation of the module above with one matrix and one Coriolis term instead of two:
//! M_RB nu' + C_RB(nu) nu = M_RB nu_r' + C_RB(nu_r) nu_r in a current that is steady in NED (Fossen
//! 2011 ch. 8, irrotational constant currents), and v_r x (m v_r) = 0.
//!
//! [`super::tangent`] and [`super::sensitivity`] are the derivatives of these equations: change
//! them together.

use super::{Inputs, Outputs, Parameters, Propulsion, State, ThrusterMode};
use crate::ParameterError;
use crate::attitude::{self, half_product};
use crate::vector::{Vec3, add, angular, cross, linear, mul, mul_transposed, scale, sub};
use nalgebra::Matrix6;

/// Rate at which the quaternion's length returns to one (1/s).
///
/// R does not depend on the length (see [`attitude::rotation`]), so this only keeps it from
/// drifting over long runs. A term of the derivative works with any integrator, whereas normalising
/// after a step would be a discrete event to an importer's variable-step solver.
pub(super) const NORM_RATE: f64 = 1.0;

/// The vehicle, with its constants derived and checked.
#[derive(Clone, Debug)]
pub struct Vehicle {
    pub(super) gravity: f64,
    /// Weight minus buoyancy (N).
    pub(super) excess_weight: f64,
    /// Buoyancy times its lever arm (N.m).
    pub(super) buoyant_moment: Vec3,
    /// M = M_RB + M_A.
    pub(super) mass: [[f64; 6]; 6],
    pub(super) mass_inverse: [[f64; 6]; 6],
    pub(super) linear_damping: [f64; 6],
    pub(super) quadratic_damping: [f64; 6],
    /// Column i: wrench of one newton of thruster i.
    pub(super) thruster_wrench: [[f64; 6]; 8],
    /// Column i: acceleration by one newton of thruster i.
    pub(super) thruster_acceleration: [[f64; 6]; 8],
    pub(super) propulsion: Propulsion,
}

/// Values derived from the inputs for as long as they are held, so that the stages of a step share
/// them and have no branches on the thruster mode.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Speeds that the rotors approach, and the rate (1/s) at which they do so.
    pub(super) rotor_target: [f64; 8],
    pub(super) rotor_rate: f64,
    /// Thrusts over rotor speed squared; 0 if rotor speeds make no thrust.
    pub(super) thrust_gain: [f64; 8],
    /// Thrust that does not depend on the rotors (N).
    direct_thrust: [f64; 8],
    wrench: [f64; 6],
    pub(super) current_ned: Vec3,
}

/// The states other than the rotor speeds, or their time derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) p_ned: Vec3,
    pub(super) quaternion: [f64; 4],
    pub(super) nu: [f64; 6],
}

impl Drive {
    /// Time derivative of the rotor speeds.
    #[inline(always)]
    fn rotor_acceleration(&self, speed: &[f64; 8]) -> [f64; 8] {
        core::array::from_fn(|i| (self.rotor_target[i] - speed[i]) * self.rotor_rate)
    }

    /// The rate of the whole state from that of the body.
    #[inline(always)]
    fn beside_rotors(&self, body: Body, speed: &[f64; 8]) -> State {
        let Body { p_ned, quaternion, nu } = body;
        State { p_ned, quaternion, nu, rotor_speed: self.rotor_acceleration(speed) }
    }

    /// Thrusts that follow the rotor speeds (N).
    #[inline(always)]
    pub(super) fn lagged_thrust(&self, s: &[f64; 8]) -> [f64; 8] {
        core::array::from_fn(|i| self.thrust_gain[i] * s[i] * s[i].abs())
    }

    /// Thrusts at these rotor speeds (N).
    #[inline(always)]
    fn thrust(&self, speed: &[f64; 8]) -> [f64; 8] {
        let lagged = self.lagged_thrust(speed);
        core::array::from_fn(|i| self.direct_thrust[i] + lagged[i])
    }
}

impl Vehicle {
    /// Checks the parameters and derives the constants.
    ///
    /// # Errors
    /// Names the parameter that is not physical: not finite, wrong sign, matrix not symmetric or
    /// not positive definite.
    pub fn new(parameters: &Parameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let (mass, buoyancy) = (parameters.mass_matrix(), parameters.buoyancy_force());
        let mass_inverse = inverse(&mass)?;
        let thruster_wrench = parameters.propulsion.thrusters.map(|t| t.unit_wrench());
        Ok(Self {
            gravity: parameters.gravity,
            excess_weight: parameters.weight() - buoyancy,
            buoyant_moment: scale(parameters.centre_of_buoyancy, buoyancy),
            mass,
            mass_inverse,
            linear_damping: parameters.linear_damping,
            quadratic_damping: parameters.quadratic_damping,
            thruster_wrench,
            thruster_acceleration: thruster_wrench.map(|wrench| mul6(&mass_inverse, &wrench)),
            propulsion: parameters.propulsion,
        })
    }

    /// Time derivative of the state.
    #[must_use]
    pub fn derivative(&self, state: &State, inputs: &Inputs) -> State {
        self.rate(state, &self.drive(inputs))
    }

    /// Everything that can be observed in a state.
    #[must_use]
    pub fn outputs(&self, state: &State, inputs: &Inputs) -> Outputs {
        let thrust = self.thrust(state, inputs);
        let r_nb = attitude::rotation(state.quaternion);
        let applied = self.applied(&inputs.wrench, &thrust);
        let nu_dot = self.acceleration(&state.nu, &r_nb, applied, inputs.current_ned);
        let (v, omega) = (linear(&state.nu), angular(&state.nu));
        let gravity_body = scale(r_nb[2], self.gravity);
        Outputs {
            p_ned: state.p_ned,
            euler: attitude::euler_of_rotation(&r_nb),
            quaternion: attitude::normalised(state.quaternion),
            nu: state.nu,
            nu_dot,
            v_ned: mul(&r_nb, v),
            specific_force: sub(add(linear(&nu_dot), cross(omega, v)), gravity_body),
            thrust,
            rotor_speed: self.rotor_speed(state, inputs),
        }
    }

    pub(super) fn thrust(&self, state: &State, inputs: &Inputs) -> [f64; 8] {
        let p = &self.propulsion;
        if p.mode == ThrusterMode::Force {
            return p.direct_thrust(inputs);
        }
        let (gain, s) = (p.thrust_gains(inputs), &state.rotor_speed);
        core::array::from_fn(|i| gain[i] * s[i] * s[i].abs())
    }

    #[inline(always)]
    fn rotor_speed(&self, state: &State, inputs: &Inputs) -> [f64; 8] {
        let p = &self.propulsion;
        match p.mode {
            ThrusterMode::Force => p.speeds(&inputs.thruster_force),
            _ => state.rotor_speed,
        }
    }

    /// Rate (1/s) of the rotors' lag; the mode without lag leaves the speeds as they are.
    pub(super) fn rotor_rate(&self) -> f64 {
        match self.propulsion.mode {
            ThrusterMode::Force => 0.0,
            _ => 1.0 / self.propulsion.rotor_time_constant,
        }
    }

    /// See [`Propulsion::kinks`].
    #[must_use]
    #[inline]
    pub fn kinks(&self, inputs: &Inputs) -> ([f64; 8], [f64; 8]) {
        self.propulsion.kinks(inputs)
    }

    /// Values derived from the inputs, for as long as they are held.
    #[must_use]
    pub fn drive(&self, inputs: &Inputs) -> Drive {
        let p = &self.propulsion;
        let mut drive = Drive {
            rotor_target: [0.0; 8],
            rotor_rate: self.rotor_rate(),
            thrust_gain: p.thrust_gains(inputs),
            direct_thrust: [0.0; 8],
            wrench: inputs.wrench,
            current_ned: inputs.current_ned,
        };
        match p.mode {
            ThrusterMode::ForceWithLag => drive.rotor_target = p.speeds(&inputs.thruster_force),
            ThrusterMode::RotorSpeed => {
                let fastest = p.speed(p.thrust_limit);
                drive.rotor_target = inputs.thruster_speed.map(|s| s.clamp(-fastest, fastest));
            }
            ThrusterMode::Force => {
                drive.rotor_target = p.speeds(&inputs.thruster_force);
                drive.thrust_gain = [0.0; 8];
                drive.direct_thrust = p.direct_thrust(inputs);
            }
        }
        drive
    }

    /// Time derivative of the state under a [`drive`](Self::drive): the same bits as
    /// [`derivative`](Self::derivative), without evaluating the inputs again.
    #[inline]
    #[must_use]
    pub fn rate(&self, state: &State, drive: &Drive) -> State {
        drive.beside_rotors(self.whole_rate(state, drive), &state.rotor_speed)
    }

    /// The part of [`rate`](Self::rate) for the states other than the rotor speeds.
    #[inline]
    pub(super) fn whole_rate(&self, state: &State, drive: &Drive) -> Body {
        let applied = self.applied(&drive.wrench, &drive.thrust(&state.rotor_speed));
        self.body_rate(&state.quaternion, &state.nu, &applied, drive.current_ned)
    }

    /// The same bits as [`rate`](Self::rate), if the outputs for the same state and inputs are
    /// known: they already contain velocity in NED and acceleration, the costly parts.
    #[inline(always)]
    #[must_use]
    pub fn rate_beside(&self, state: &State, outputs: &Outputs, drive: &Drive) -> State {
        drive.beside_rotors(known_rate(state, outputs), &state.rotor_speed)
    }

    /// Wrench on the body by everything but gravity, water and buoyancy, without the thrusts that
    /// follow the rotor speeds.
    #[inline(always)]
    pub(super) fn held_wrench(&self, drive: &Drive) -> [f64; 6] {
        self.applied(&drive.wrench, &drive.direct_thrust)
    }

    /// The sum of an external wrench and that of the thrusts.
    #[inline(always)]
    fn applied(&self, wrench: &[f64; 6], thrust: &[f64; 8]) -> [f64; 6] {
        // Never -0, so that a thrust of 0 and of -0 give the same result.
        let mut sum = wrench.map(|component| component + 0.0);
        add_wrench(&mut sum, &self.thruster_wrench, thrust);
        sum
    }

    /// Time derivatives of the states other than the rotor speeds, under an applied wrench.
    // Not inlined: four copies in a Runge-Kutta step overflow the processor's decoded-instruction
    // cache, which was measured to cost a third of its speed.
    #[inline(never)]
    pub(super) fn body_rate(
        &self,
        quaternion: &[f64; 4],
        nu: &[f64; 6],
        applied: &[f64; 6],
        current_ned: Vec3,
    ) -> Body {
        let r_nb = attitude::rotation(*quaternion);
        Body {
            p_ned: mul(&r_nb, linear(nu)),
            quaternion: quaternion_rate(*quaternion, angular(nu)),
            nu: self.acceleration(nu, &r_nb, *applied, current_ned),
        }
    }

    #[inline(always)]
    fn acceleration(
        &self,
        nu: &[f64; 6],
        r_nb: &[Vec3; 3],
        applied: [f64; 6],
        current_ned: Vec3,
    ) -> [f64; 6] {
        let omega = angular(nu);
        let current = mul_transposed(r_nb, current_ned);
        let v_r = sub(linear(nu), current);
        let nu_r = [v_r[0], v_r[1], v_r[2], omega[0], omega[1], omega[2]];
        let momentum = mul6(&self.mass, &nu_r);
        let (p, h) = (linear(&momentum), angular(&momentum));

        // Weight and buoyancy both act along the third row of R, which is down in body axes.
        let down = r_nb[2];
        let force = sub(scale(down, self.excess_weight), cross(omega, p));
        let turning = add(cross(omega, h), cross(v_r, p));
        let moment = sub(cross(down, self.buoyant_moment), turning);

        let mut tau = applied;
        for i in 0..6 {
            let damping = self.linear_damping[i] + self.quadratic_damping[i] * nu_r[i].abs();
            tau[i] -= damping * nu_r[i];
        }
        for i in 0..3 {
            tau[i] += force[i];
            tau[3 + i] += moment[i];
        }
        let mut nu_dot = mul6(&self.mass_inverse, &tau);
        let turn = cross(omega, current);
        for i in 0..3 {
            nu_dot[i] -= turn[i];
        }
        nu_dot
    }
}

/// The rates of [`Vehicle::body_rate`] from the outputs for the same state and inputs.
#[inline(always)]
pub(super) fn known_rate(state: &State, outputs: &Outputs) -> Body {
    Body {
        p_ned: outputs.v_ned,
        quaternion: quaternion_rate(state.quaternion, angular(&state.nu)),
        nu: outputs.nu_dot,
    }
}

/// Adds the wrench of eight thrusts (N).
#[inline(always)]
pub(super) fn add_wrench(wrench: &mut [f64; 6], columns: &[[f64; 6]; 8], thrust: &[f64; 8]) {
    for (column, t) in columns.iter().zip(thrust) {
        for i in 0..6 {
            wrench[i] += column[i] * t;
        }
    }
}

/// `q' = 1/2 q (0, omega)`, plus a term towards unit length.
#[inline(always)]
fn quaternion_rate(q: [f64; 4], omega: Vec3) -> [f64; 4] {
    let (spin, stretch) = (half_product(q, omega), stretch_rate(q));
    core::array::from_fn(|i| spin[i] + stretch * q[i])
}

/// Rate (1/s) at which the quaternion grows towards unit length.
#[inline(always)]
pub(super) fn stretch_rate([w, x, y, z]: [f64; 4]) -> f64 {
    0.5 * NORM_RATE * (1.0 - (w * w + x * x + y * y + z * z))
}

/// `m a` of a symmetric matrix: summed by columns (its rows), which the compiler vectorises, and in
/// two halves, because the linear and the angular part of `a` are known at different times.
#[inline(always)]
pub(super) fn mul6(m: &[[f64; 6]; 6], a: &[f64; 6]) -> [f64; 6] {
    core::array::from_fn(|i| {
        (m[0][i] * a[0] + m[1][i] * a[1] + m[2][i] * a[2])
            + (m[3][i] * a[3] + m[4][i] * a[4] + m[5][i] * a[5])
    })
}

fn inverse(m: &[[f64; 6]; 6]) -> Result<[[f64; 6]; 6], ParameterError> {
    let Some(factor) = Matrix6::from_fn(|i, j| m[i][j]).cholesky() else {
        let reason = "mass matrix M_RB + M_A must be positive definite";
        return Err(ParameterError::new("added_mass", format!("{m:?}"), reason));
    };
    let n = factor.inverse();
    Ok(core::array::from_fn(|i| core::array::from_fn(|j| 0.5 * (n[(i, j)] + n[(j, i)]))))
}
