//! Right-hand side of the six-degree-of-freedom equations of motion.
//!
//! Fossen (2011) eq (6.43) ff., eqs (5)-(26) of the paper. Body frame at the centre of gravity, so
//! `C_RB nu = [m omega x v; omega x I omega]`. Added mass: `[p_A; h_A] = M_A nu_r` and
//! `C_A nu_r = [omega x p_A; omega x h_A + v_r x p_A]`, which for a diagonal M_A is eq (14).

use super::{Inputs, Outputs, Parameters, Propulsion, State, ThrusterMode};
use crate::ParameterError;
use crate::attitude;
use crate::vector::{Vec3, add, angular, cross, linear, mul, mul_transposed, scale, sub};
use nalgebra::Matrix6;

/// Rate at which the quaternion's length returns to one (1/s).
///
/// R does not depend on the length (see [`attitude::rotation`]), so this only keeps it from
/// wandering off over long runs. A term of the derivative serves any integrator alike, where
/// normalising after a step would be a discrete event to an importer's variable-step solver.
const NORM_RATE: f64 = 1.0;

/// The vehicle, its constants derived and checked.
#[derive(Clone, Debug)]
pub struct Vehicle {
    mass: f64,
    inertia: [Vec3; 3],
    gravity: f64,
    weight: f64,
    buoyancy: f64,
    centre_of_buoyancy: Vec3,
    added_mass: [[f64; 6]; 6],
    mass_inverse: [[f64; 6]; 6],
    linear_damping: [f64; 6],
    quadratic_damping: [f64; 6],
    /// Column i: wrench of one newton of thruster i.
    thruster_wrench: [[f64; 6]; 8],
    propulsion: Propulsion,
}

/// What the inputs amount to for the length of a step, so that its four stages share it and have
/// no branches on the thruster mode.
pub(super) struct Drive {
    /// Speeds that the rotors tend to, and the rate (1/s) at which they do.
    rotor_target: [f64; 8],
    rotor_rate: f64,
    /// Thrust over rotor speed squared; 0 where rotor speeds make no thrust.
    thrust_gain: f64,
    /// Wrench that does not depend on the state.
    wrench: [f64; 6],
    current_ned: Vec3,
}

impl Vehicle {
    /// Checks the parameters and derives the constants.
    ///
    /// # Errors
    /// Names the parameter that is not physical: not finite, wrong sign, matrix not symmetric or
    /// not positive definite.
    pub fn new(parameters: &Parameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            mass: parameters.mass,
            inertia: parameters.inertia.matrix(),
            gravity: parameters.gravity,
            weight: parameters.weight(),
            buoyancy: parameters.buoyancy_force(),
            centre_of_buoyancy: parameters.centre_of_buoyancy,
            added_mass: parameters.symmetric_added_mass(),
            mass_inverse: inverse(&parameters.mass_matrix())?,
            linear_damping: parameters.linear_damping,
            quadratic_damping: parameters.quadratic_damping,
            thruster_wrench: parameters.propulsion.thrusters.map(|t| t.unit_wrench()),
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
        let drive = self.drive(inputs);
        let dot = self.rate(state, &drive);
        let r_nb = attitude::rotation(state.quaternion);
        let gravity_body = scale(r_nb[2], self.gravity);
        let (v, omega) = (linear(&state.nu), angular(&state.nu));
        Outputs {
            p_ned: state.p_ned,
            euler: attitude::to_euler(state.quaternion),
            quaternion: attitude::normalised(state.quaternion),
            nu: state.nu,
            nu_dot: dot.nu,
            v_ned: dot.p_ned,
            specific_force: sub(add(linear(&dot.nu), cross(omega, v)), gravity_body),
            thrust: self.thrust(state, inputs),
        }
    }

    fn thrust(&self, state: &State, inputs: &Inputs) -> [f64; 8] {
        let p = &self.propulsion;
        match p.mode {
            ThrusterMode::Force => inputs
                .thruster_force
                .map(|f| f.clamp(-p.thrust_limit, p.thrust_limit)),
            _ => state.rotor_speed.map(|s| p.thrust(s)),
        }
    }

    pub(super) fn drive(&self, inputs: &Inputs) -> Drive {
        let p = &self.propulsion;
        let force = inputs
            .thruster_force
            .map(|f| f.clamp(-p.thrust_limit, p.thrust_limit));
        let mut drive = Drive {
            rotor_target: [0.0; 8],
            rotor_rate: 1.0 / p.rotor_time_constant,
            thrust_gain: p.thrust_gain,
            wrench: inputs.wrench,
            current_ned: inputs.current_ned,
        };
        match p.mode {
            ThrusterMode::ForceWithLag => drive.rotor_target = force.map(|f| p.speed(f)),
            ThrusterMode::RotorSpeed => {
                let fastest = p.speed(p.thrust_limit);
                drive.rotor_target = inputs.thruster_speed.map(|s| s.clamp(-fastest, fastest));
            }
            ThrusterMode::Force => {
                drive.rotor_rate = 0.0;
                drive.thrust_gain = 0.0;
                add_wrench(&mut drive.wrench, &self.thruster_wrench, &force);
            }
        }
        drive
    }

    // Not inlined: four copies in a Runge-Kutta step overflow the processor's decoded-instruction
    // cache, which was measured to cost a third of its speed.
    #[inline(never)]
    pub(super) fn rate(&self, state: &State, drive: &Drive) -> State {
        let r_nb = attitude::rotation(state.quaternion);
        State {
            p_ned: mul(&r_nb, linear(&state.nu)),
            quaternion: quaternion_rate(state.quaternion, angular(&state.nu)),
            nu: self.acceleration(state, drive, &r_nb),
            rotor_speed: core::array::from_fn(|i| {
                (drive.rotor_target[i] - state.rotor_speed[i]) * drive.rotor_rate
            }),
        }
    }

    #[inline(always)]
    fn acceleration(&self, state: &State, drive: &Drive, r_nb: &[Vec3; 3]) -> [f64; 6] {
        let (v, omega) = (linear(&state.nu), angular(&state.nu));
        let current = mul_transposed(r_nb, drive.current_ned);
        let v_r = sub(v, current);
        let nu_r = [v_r[0], v_r[1], v_r[2], omega[0], omega[1], omega[2]];

        let momentum = mul6(&self.added_mass, &nu_r);
        let (p_a, h_a) = (linear(&momentum), angular(&momentum));
        let turn = cross(omega, current);
        let linear_force = add(scale(cross(omega, v), self.mass), cross(omega, p_a));
        let h = add(mul(&self.inertia, omega), h_a);
        let moment = add(cross(omega, h), cross(v_r, p_a));

        // Weight and buoyancy both act along the third row of R, which is down in body axes.
        let down = r_nb[2];
        let restoring = scale(cross(self.centre_of_buoyancy, down), -self.buoyancy);
        let excess = scale(down, self.weight - self.buoyancy);

        let mut tau = drive.wrench;
        let thrust = state.rotor_speed.map(|s| drive.thrust_gain * s * s.abs());
        add_wrench(&mut tau, &self.thruster_wrench, &thrust);
        for i in 0..3 {
            tau[i] += excess[i] - linear_force[i];
            tau[3 + i] += restoring[i] - moment[i];
        }
        for i in 0..6 {
            // M_A [omega x R^T v_c; 0]: the added mass feels the derivative of nu_r.
            let a = &self.added_mass;
            tau[i] -= a[0][i] * turn[0] + a[1][i] * turn[1] + a[2][i] * turn[2];
            let damping = self.linear_damping[i] + self.quadratic_damping[i] * nu_r[i].abs();
            tau[i] -= damping * nu_r[i];
        }
        mul6(&self.mass_inverse, &tau)
    }
}

/// Adds the wrench of eight thrusts (N).
#[inline(always)]
fn add_wrench(wrench: &mut [f64; 6], columns: &[[f64; 6]; 8], thrust: &[f64; 8]) {
    for (column, t) in columns.iter().zip(thrust) {
        for i in 0..6 {
            wrench[i] += column[i] * t;
        }
    }
}

#[inline(always)]
fn quaternion_rate([w, x, y, z]: [f64; 4], [p, q, r]: Vec3) -> [f64; 4] {
    let stretch = 0.5 * NORM_RATE * (1.0 - (w * w + x * x + y * y + z * z));
    [
        0.5 * (-x * p - y * q - z * r) + stretch * w,
        0.5 * (w * p + y * r - z * q) + stretch * x,
        0.5 * (w * q + z * p - x * r) + stretch * y,
        0.5 * (w * r + x * q - y * p) + stretch * z,
    ]
}

/// `m a` of a symmetric matrix: summed by columns (its rows), which the compiler vectorises.
#[inline(always)]
fn mul6(m: &[[f64; 6]; 6], a: &[f64; 6]) -> [f64; 6] {
    let mut y = [0.0; 6];
    for (column, x) in m.iter().zip(a) {
        for i in 0..6 {
            y[i] += column[i] * x;
        }
    }
    y
}

fn inverse(m: &[[f64; 6]; 6]) -> Result<[[f64; 6]; 6], ParameterError> {
    let Some(factor) = Matrix6::from_fn(|i, j| m[i][j]).cholesky() else {
        let reason = "mass matrix M_RB + M_A must be positive definite";
        return Err(ParameterError::new("added_mass", format!("{m:?}"), reason));
    };
    let n = factor.inverse();
    Ok(core::array::from_fn(|i| {
        core::array::from_fn(|j| 0.5 * (n[(i, j)] + n[(j, i)]))
    }))
}
