//! Derivatives with respect to the coefficients: how derivative and outputs of a state change, to
//! first order, as the coefficients of the vehicle change in a given direction.
//!
//! With d the change along the direction, at a fixed state and fixed inputs (otherwise as in
//! [`super::tangent`]):
//!
//! ```text
//! M dnu_r' = dtau - dM nu_r'                   from M nu_r' = tau, so d(M^-1 b) = M^-1 (db - dM M^-1 b)
//! dtau     = dB T + B dT - dg - (dD_l + dD_q |nu_r|) nu_r - [omega x dp; omega x dh + v_r x dp]
//! [dp; dh] = dM nu_r
//! dT       = (1 - loss) dgain w |w|,    dw' = d(1/tau) (w_cmd - w) + dw_cmd / tau
//! ```
//! The conventions at limits are those of [`super::tangent`]. A computed buoyancy (`None`) changes
//! with density, gravity and volume; a given one changes only by itself.

use super::dynamics::{add_wrench, mul6};
use super::tangent::Tangent;
use super::{Inputs, Outputs, Parameters, Propulsion, State, Thruster, ThrusterMode};
use crate::vector::{add, angular, cross, linear, scale, sub};

/// Change of a vehicle's constants as its coefficients change along a direction.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    gravity: f64,
    excess_weight: f64,
    buoyant_moment: [f64; 3],
    mass: [[f64; 6]; 6],
    linear_damping: [f64; 6],
    quadratic_damping: [f64; 6],
    thruster_wrench: [[f64; 6]; 8],
    rotor_rate: f64,
    thrust_gain: f64,
    thrust_limit: f64,
}

impl Sensitivity {
    /// Along the direction `d`, which is a set of coefficients that contains changes: its buoyancy
    /// counts if that of `at` is given, its thruster mode never.
    #[must_use]
    pub fn new(at: &Parameters, d: &Parameters) -> Self {
        let d_weight = d.mass * at.gravity + at.mass * d.gravity;
        let d_buoyancy = match at.buoyancy {
            Some(_) => d.buoyancy.unwrap_or_default(),
            None => {
                let (density, volume) = (at.density * d.volume, d.density * at.volume);
                at.gravity * (density + volume) + d.gravity * at.density * at.volume
            }
        };
        let (p, d_p) = (&at.propulsion, &d.propulsion);
        let rate = 1.0 / p.rotor_time_constant;
        Self {
            gravity: d.gravity,
            excess_weight: d_weight - d_buoyancy,
            buoyant_moment: add(
                scale(d.centre_of_buoyancy, at.buoyancy_force()),
                scale(at.centre_of_buoyancy, d_buoyancy),
            ),
            // Linear in the coefficients, so the matrix of the changes is the change of the matrix.
            mass: d.mass_matrix(),
            linear_damping: d.linear_damping,
            quadratic_damping: d.quadratic_damping,
            thruster_wrench: core::array::from_fn(|i| {
                d_unit_wrench(&p.thrusters[i], &d_p.thrusters[i])
            }),
            rotor_rate: match p.mode {
                ThrusterMode::Force => 0.0,
                _ => -d_p.rotor_time_constant * rate * rate,
            },
            thrust_gain: d_p.thrust_gain,
            thrust_limit: d_p.thrust_limit,
        }
    }

    /// Change of the thrusts.
    fn thrust(&self, p: &Propulsion, state: &State, inputs: &Inputs) -> [f64; 8] {
        let sound = match p.mode {
            ThrusterMode::Force => p.command(inputs).map(|f| self.clipped(p, f)),
            _ => state.rotor_speed.map(|s| self.thrust_gain * s * s.abs()),
        };
        core::array::from_fn(|i| (1.0 - inputs.thruster_loss[i]) * sound[i])
    }

    /// Change of a force (N) clipped to the limit.
    fn clipped(&self, p: &Propulsion, force: f64) -> f64 {
        if force.abs() <= p.thrust_limit { 0.0 } else { self.thrust_limit * force.signum() }
    }

    /// Change of the speed that a rotor approaches, `target` at this command.
    fn rotor_target(&self, p: &Propulsion, command: f64, target: f64) -> f64 {
        let gain = self.thrust_gain / p.thrust_gain;
        let limit = self.thrust_limit / p.thrust_limit;
        let relative = match p.mode {
            ThrusterMode::RotorSpeed if command.abs() <= p.speed(p.thrust_limit) => 0.0,
            ThrusterMode::RotorSpeed => limit - gain,
            // The square root of force over gain, with the force at its limit or as commanded.
            _ if command.abs() <= p.thrust_limit => -gain,
            _ => limit - gain,
        };
        0.5 * target * relative
    }
}

impl Tangent<'_> {
    /// Change of the derivative and the outputs of the vehicle as the coefficients change, at fixed
    /// state and inputs.
    #[must_use]
    pub fn with_coefficients(&self, d: &Sensitivity) -> (State, Outputs) {
        let (vehicle, state, inputs) = (self.vehicle, self.state, self.inputs);
        let (p, down) = (&vehicle.propulsion, self.r_nb[2]);
        let rate = vehicle.derivative(state, inputs);
        let thrust = d.thrust(p, state, inputs);
        let nu_dot = self.d_acceleration(d, &rate.nu, &thrust);
        let (command, target) = (p.command(inputs), vehicle.drive(inputs).rotor_target);
        let d_target: [f64; 8] = core::array::from_fn(|i| d.rotor_target(p, command[i], target[i]));
        let d_rate = State {
            p_ned: [0.0; 3],
            quaternion: [0.0; 4],
            nu: nu_dot,
            rotor_speed: core::array::from_fn(|i| {
                (target[i] - state.rotor_speed[i]) * d.rotor_rate
                    + d_target[i] * vehicle.rotor_rate()
            }),
        };
        let d_outputs = Outputs {
            p_ned: [0.0; 3],
            euler: [0.0; 3],
            quaternion: [0.0; 4],
            nu: [0.0; 6],
            nu_dot,
            v_ned: [0.0; 3],
            specific_force: sub(linear(&nu_dot), scale(down, d.gravity)),
            thrust,
            rotor_speed: if p.mode == ThrusterMode::Force { d_target } else { [0.0; 8] },
        };
        (d_rate, d_outputs)
    }

    /// Change of nu', which is `nu_dot`; `d_thrust` is the change of the thrusts.
    fn d_acceleration(&self, d: &Sensitivity, nu_dot: &[f64; 6], d_thrust: &[f64; 8]) -> [f64; 6] {
        let (vehicle, v_r, down) = (self.vehicle, self.v_r, self.r_nb[2]);
        let omega = angular(&self.state.nu);
        let nu_r = [v_r[0], v_r[1], v_r[2], omega[0], omega[1], omega[2]];
        let turn = cross(omega, self.current);
        let nu_r_dot: [f64; 6] =
            core::array::from_fn(|i| if i < 3 { nu_dot[i] + turn[i] } else { nu_dot[i] });
        let (d_momentum, inertial) = (mul6(&d.mass, &nu_r), mul6(&d.mass, &nu_r_dot));
        let (d_p, d_h) = (linear(&d_momentum), angular(&d_momentum));
        let force = sub(scale(down, d.excess_weight), cross(omega, d_p));
        let turning = add(cross(omega, d_h), cross(v_r, d_p));
        let moment = sub(cross(down, d.buoyant_moment), turning);

        let thrust = vehicle.thrust(self.state, self.inputs);
        let mut tau = [0.0; 6];
        add_wrench(&mut tau, &d.thruster_wrench, &thrust);
        add_wrench(&mut tau, &vehicle.thruster_wrench, d_thrust);
        for i in 0..6 {
            let damping = d.linear_damping[i] + d.quadratic_damping[i] * nu_r[i].abs();
            tau[i] -= damping * nu_r[i] + inertial[i];
        }
        for i in 0..3 {
            tau[i] += force[i];
            tau[3 + i] += moment[i];
        }
        mul6(&vehicle.mass_inverse, &tau)
    }
}

/// Change of [`Thruster::unit_wrench`]: axis e, moment r x e.
fn d_unit_wrench(at: &Thruster, d: &Thruster) -> [f64; 6] {
    let (st, ct) = libm::sincos(at.theta_deg.to_radians());
    let (sp, cp) = libm::sincos(at.psi_deg.to_radians());
    let (d_theta, d_psi) = (d.theta_deg.to_radians(), d.psi_deg.to_radians());
    let axis = [ct * cp, ct * sp, -st];
    let d_axis =
        [-st * cp * d_theta - ct * sp * d_psi, -st * sp * d_theta + ct * cp * d_psi, -ct * d_theta];
    let turned = cross([at.lx, at.ly, at.lz], d_axis);
    let moment = add(cross([d.lx, d.ly, d.lz], axis), turned);
    [d_axis[0], d_axis[1], d_axis[2], moment[0], moment[1], moment[2]]
}
