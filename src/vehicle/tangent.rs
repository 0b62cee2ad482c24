//! Directional derivatives: how derivative and outputs change as state and inputs change in a given
//! direction, to first order. They are derived by hand, so they are exact to rounding and as cheap
//! as the model itself.
//!
//! With d the change along the direction and everything else the values at the point (see
//! [`super::dynamics`]):
//!
//! ```text
//! dtheta    = 2 Im(q* dq) / |q|^2              body turned about its own axes: dR = R [dtheta x]
//! d(R^T a)  = R^T a x dtheta + R^T da          serves the current c and the direction of gravity
//! M dnu_r'  = dtau - dg - (D_l + 2 D_q |nu_r|) dnu_r
//!             - [domega x p + omega x dp; domega x h + omega x dh + dv_r x p + v_r x dp]
//! dnu'      = dnu_r' - [domega x c + omega x dc; 0]
//! dp'       = R (dv + dtheta x v)
//! dq'       = 1/2 dq (0, omega) + 1/2 q (0, domega) + s dq + ds q,    s = NORM_RATE (1 - |q|^2) / 2
//! dT        = (1 - loss) 2 gain |w| dw - dloss gain w |w|,    dw' = (dw_cmd - dw) / tau
//! ```
//! The Euler angles follow dtheta as they follow omega: Fossen (2011) eq (2.41), eq (4) of the
//! paper.
//!
//! Where no derivative exists, the convention is:
//! * a command at its limit counts as not clipped, beyond it as clipped (slope zero);
//! * a force command of exactly zero in `ForceWithLag` has slope zero, not the infinite slope of
//!   the square root: one infinity would spoil every sum it enters, and the thrust, which is the
//!   square of the rotor speed, does start with slope zero. Any other command, however small, has
//!   its slope;
//! * at a pitch of exactly 90 degrees roll and yaw rotate about one axis: d(yaw) and d(pitch) are
//!   zero.

use super::dynamics::{NORM_RATE, add_wrench, mul6, stretch_rate};
use super::{Inputs, Outputs, State, ThrusterMode, Vehicle};
use crate::attitude::{self, half_product};
use crate::vector::{Vec3, add, angular, cross, linear, mul, mul_transposed, scale, sub};

/// The vehicle linearised at a point: computed once for any number of directions.
#[derive(Clone, Debug)]
pub struct Tangent<'a> {
    pub(super) vehicle: &'a Vehicle,
    pub(super) state: &'a State,
    pub(super) inputs: &'a Inputs,
    /// `2 / |q|^2`.
    two_over_norm2: f64,
    pub(super) r_nb: [Vec3; 3],
    /// Current and velocity relative to the water, body.
    pub(super) current: Vec3,
    pub(super) v_r: Vec3,
}

/// The common part of derivative and outputs.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// dtheta.
    turn: Vec3,
    thrust: [f64; 8],
    nu_dot: [f64; 6],
    v_ned: Vec3,
}

impl Vehicle {
    /// Linearises derivative and outputs at a point.
    #[inline(always)]
    #[must_use]
    pub fn tangent<'a>(&'a self, state: &'a State, inputs: &'a Inputs) -> Tangent<'a> {
        let r_nb = attitude::rotation(state.quaternion);
        let current = mul_transposed(&r_nb, inputs.current_ned);
        Tangent {
            vehicle: self,
            state,
            inputs,
            two_over_norm2: 2.0 / dot(state.quaternion, state.quaternion),
            r_nb,
            current,
            v_r: sub(linear(&state.nu), current),
        }
    }
}

impl Tangent<'_> {
    /// Change of [`Vehicle::derivative`] along a direction.
    #[must_use]
    pub fn derivative(&self, d_state: &State, d_inputs: &Inputs) -> State {
        self.d_derivative(d_state, d_inputs, &self.motion(d_state, d_inputs))
    }

    /// Change of [`Vehicle::outputs`] along a direction.
    #[must_use]
    pub fn outputs(&self, d_state: &State, d_inputs: &Inputs) -> Outputs {
        self.d_outputs(d_state, d_inputs, self.motion(d_state, d_inputs))
    }

    /// Both at once, with their common part computed once: a column of the Jacobian if the
    /// direction is an axis.
    #[inline(always)]
    #[must_use]
    pub fn along(&self, d_state: &State, d_inputs: &Inputs) -> (State, Outputs) {
        let motion = self.motion(d_state, d_inputs);
        (self.d_derivative(d_state, d_inputs, &motion), self.d_outputs(d_state, d_inputs, motion))
    }

    /// An axis changes few of these; unchanged terms are not computed.
    #[inline(always)]
    fn motion(&self, d_state: &State, d_inputs: &Inputs) -> Motion {
        let (v, omega) = (linear(&self.state.nu), angular(&self.state.nu));
        let (d_v, d_omega) = (linear(&d_state.nu), angular(&d_state.nu));
        let mut motion = Motion::default();
        let (mut tau, mut d_current, mut d_along) = (d_inputs.wrench, [0.0; 3], d_v);
        if moves(&d_state.quaternion) {
            motion.turn = self.turn(d_state.quaternion);
            d_current = cross(self.current, motion.turn);
            d_along = add(d_v, cross(motion.turn, v));
            self.add_restoring(&mut tau, motion.turn);
        }
        if moves(&d_inputs.current_ned) {
            d_current = add(d_current, mul_transposed(&self.r_nb, d_inputs.current_ned));
        }
        if moves(self.pushing(d_state, d_inputs)) || moves(&d_inputs.thruster_loss) {
            motion.thrust = self.thrust(d_state, d_inputs);
            add_wrench(&mut tau, &self.vehicle.thruster_wrench, &motion.thrust);
        }
        let mut drift = [0.0; 3];
        if moves(&d_state.nu) || moves(&d_current) {
            let d_v_r = sub(d_v, d_current);
            self.add_hydrodynamics(&mut tau, d_v_r, d_omega);
            drift = add(cross(d_omega, self.current), cross(omega, d_current));
        }
        if moves(&tau) {
            motion.nu_dot = mul6(&self.vehicle.mass_inverse, &tau);
        }
        for i in 0..3 {
            motion.nu_dot[i] -= drift[i];
        }
        if moves(&d_along) {
            motion.v_ned = mul(&self.r_nb, d_along);
        }
        motion
    }

    /// dtheta: the rotation about body axes that corresponds to a change of the quaternion; a
    /// change of its length corresponds to none.
    #[inline(always)]
    fn turn(&self, d_q: [f64; 4]) -> Vec3 {
        let q = self.state.quaternion;
        let (axis, d_axis) = ([q[1], q[2], q[3]], [d_q[1], d_q[2], d_q[3]]);
        let across = add(scale(axis, d_q[0]), cross(axis, d_axis));
        scale(sub(scale(d_axis, q[0]), across), self.two_over_norm2)
    }

    /// Change of `q / |q|`.
    #[inline(always)]
    fn d_normalised(&self, d_q: [f64; 4]) -> [f64; 4] {
        let (q, over_norm2) = (self.state.quaternion, 0.5 * self.two_over_norm2);
        let (over_norm, along) = (over_norm2.sqrt(), dot(q, d_q) * over_norm2);
        core::array::from_fn(|i| (d_q[i] - along * q[i]) * over_norm)
    }

    /// Weight and buoyancy.
    #[inline(always)]
    fn add_restoring(&self, tau: &mut [f64; 6], turn: Vec3) {
        let d_down = cross(self.r_nb[2], turn);
        let d_moment = cross(d_down, self.vehicle.buoyant_moment);
        for i in 0..3 {
            tau[i] += self.vehicle.excess_weight * d_down[i];
            tau[3 + i] += d_moment[i];
        }
    }

    /// Coriolis forces of body and added mass, damping.
    #[inline(always)]
    fn add_hydrodynamics(&self, tau: &mut [f64; 6], d_v_r: Vec3, d_omega: Vec3) {
        let (vehicle, v_r, omega) = (self.vehicle, self.v_r, angular(&self.state.nu));
        let nu_r = [v_r[0], v_r[1], v_r[2], omega[0], omega[1], omega[2]];
        let d_nu_r = [d_v_r[0], d_v_r[1], d_v_r[2], d_omega[0], d_omega[1], d_omega[2]];
        let momentum = mul6(&vehicle.mass, &nu_r);
        let (p, h) = (linear(&momentum), angular(&momentum));
        let d_momentum = mul6(&vehicle.mass, &d_nu_r);
        let (d_p, d_h) = (linear(&d_momentum), angular(&d_momentum));
        let mut coriolis = cross(omega, d_p);
        let mut turning = add(cross(omega, d_h), add(cross(d_v_r, p), cross(v_r, d_p)));
        if moves(&d_omega) {
            coriolis = add(coriolis, cross(d_omega, p));
            turning = add(turning, cross(d_omega, h));
        }
        for i in 0..6 {
            let slope = 2.0 * vehicle.quadratic_damping[i] * nu_r[i].abs();
            tau[i] -= (vehicle.linear_damping[i] + slope) * d_nu_r[i];
        }
        for i in 0..3 {
            tau[i] -= coriolis[i];
            tau[3 + i] -= turning[i];
        }
    }

    /// The variables that determine the thrusts: commands or rotor speeds.
    #[inline(always)]
    fn pushing<'b>(&self, state: &'b State, inputs: &'b Inputs) -> &'b [f64; 8] {
        match self.vehicle.propulsion.mode {
            ThrusterMode::Force => &inputs.thruster_force,
            _ => &state.rotor_speed,
        }
    }

    /// Change of the thrusts.
    #[inline(always)]
    fn thrust(&self, d_state: &State, d_inputs: &Inputs) -> [f64; 8] {
        let p = &self.vehicle.propulsion;
        let (at, d) = (self.pushing(self.state, self.inputs), self.pushing(d_state, d_inputs));
        let (loss, d_loss) = (&self.inputs.thruster_loss, &d_inputs.thruster_loss);
        core::array::from_fn(|i| {
            let (sound, d_sound) = match p.mode {
                ThrusterMode::Force => (
                    at[i].clamp(-p.thrust_limit, p.thrust_limit),
                    within(at[i], p.thrust_limit) * d[i],
                ),
                _ => (p.thrust(at[i]), 2.0 * p.thrust_gain * at[i].abs() * d[i]),
            };
            (1.0 - loss[i]) * d_sound - d_loss[i] * sound
        })
    }

    /// Change of the speeds that the rotors approach.
    #[inline(always)]
    fn rotor_target(&self, d_inputs: &Inputs) -> [f64; 8] {
        let p = &self.vehicle.propulsion;
        let (command, d_command) = (p.command(self.inputs), p.command(d_inputs));
        if p.mode == ThrusterMode::Force || !moves(d_command) {
            return [0.0; 8];
        }
        if p.mode == ThrusterMode::RotorSpeed {
            let fastest = p.speed(p.thrust_limit);
            return core::array::from_fn(|i| within(command[i], fastest) * d_command[i]);
        }
        self.speeds(command, d_command)
    }

    /// Change of the rotor speeds that correspond to commanded forces.
    #[inline(always)]
    fn speeds(&self, force: &[f64; 8], d_force: &[f64; 8]) -> [f64; 8] {
        let p = &self.vehicle.propulsion;
        let mut d_speed = [0.0; 8];
        for i in 0..8 {
            if d_force[i] != 0.0 {
                let slope = inverse(2.0 * (p.thrust_gain * force[i].abs()).sqrt());
                d_speed[i] = within(force[i], p.thrust_limit) * slope * d_force[i];
            }
        }
        d_speed
    }

    /// Change of the rotor speeds among the outputs.
    #[inline(always)]
    fn rotor_speed(&self, d_state: &State, d_inputs: &Inputs) -> [f64; 8] {
        match self.vehicle.propulsion.mode {
            ThrusterMode::Force => {
                self.speeds(&self.inputs.thruster_force, &d_inputs.thruster_force)
            }
            _ => d_state.rotor_speed,
        }
    }

    /// Change of the accelerations of the rotors.
    #[inline(always)]
    fn rotor_acceleration(&self, d_state: &State, d_inputs: &Inputs) -> [f64; 8] {
        let (d_speed, d_command) =
            (&d_state.rotor_speed, self.vehicle.propulsion.command(d_inputs));
        if !moves(d_speed) && !moves(d_command) {
            return [0.0; 8];
        }
        let (d_target, rate) = (self.rotor_target(d_inputs), self.vehicle.rotor_rate());
        core::array::from_fn(|i| (d_target[i] - d_speed[i]) * rate)
    }

    /// Change of the rate of the quaternion.
    #[inline(always)]
    fn quaternion_rate(&self, d_q: [f64; 4], d_omega: Vec3) -> [f64; 4] {
        if !moves(&d_q) && !moves(&d_omega) {
            return [0.0; 4];
        }
        let q = self.state.quaternion;
        let turned = half_product(d_q, angular(&self.state.nu));
        let faster = half_product(q, d_omega);
        let (stretch, d_stretch) = (stretch_rate(q), -NORM_RATE * dot(q, d_q));
        core::array::from_fn(|i| turned[i] + faster[i] + stretch * d_q[i] + d_stretch * q[i])
    }

    #[inline(always)]
    fn d_derivative(&self, d_state: &State, d_inputs: &Inputs, motion: &Motion) -> State {
        State {
            p_ned: motion.v_ned,
            quaternion: self.quaternion_rate(d_state.quaternion, angular(&d_state.nu)),
            nu: motion.nu_dot,
            rotor_speed: self.rotor_acceleration(d_state, d_inputs),
        }
    }

    #[inline(always)]
    fn d_outputs(&self, d_state: &State, d_inputs: &Inputs, motion: Motion) -> Outputs {
        let (v, omega) = (linear(&self.state.nu), angular(&self.state.nu));
        let down = self.r_nb[2];
        let d_gravity_body = scale(cross(down, motion.turn), self.vehicle.gravity);
        let (d_v, d_omega) = (linear(&d_state.nu), angular(&d_state.nu));
        let centripetal = add(cross(d_omega, v), cross(omega, d_v));
        Outputs {
            p_ned: d_state.p_ned,
            euler: euler_rate(down, motion.turn),
            quaternion: self.d_normalised(d_state.quaternion),
            nu: d_state.nu,
            nu_dot: motion.nu_dot,
            v_ned: motion.v_ned,
            specific_force: sub(add(linear(&motion.nu_dot), centripetal), d_gravity_body),
            thrust: motion.thrust,
            rotor_speed: self.rotor_speed(d_state, d_inputs),
        }
    }
}

/// Change of roll, pitch and yaw as the body rotates about its own axes; `down` is the third row of
/// R, `[-sin(pitch), cos(pitch) sin(roll), cos(pitch) cos(roll)]`.
#[inline(always)]
fn euler_rate(down: Vec3, turn: Vec3) -> Vec3 {
    let over_cos2 = inverse(down[1] * down[1] + down[2] * down[2]);
    let yaw = (down[1] * turn[1] + down[2] * turn[2]) * over_cos2;
    let pitch = (down[2] * turn[1] - down[1] * turn[2]) * over_cos2.sqrt();
    [turn[0] - down[0] * yaw, pitch, yaw]
}

#[inline(always)]
fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// Whether any element is not zero, checked without a branch for each.
#[inline(always)]
fn moves(direction: &[f64]) -> bool {
    direction.iter().fold(false, |any, d| any | (*d != 0.0))
}

/// Slope of clipping at a limit.
#[inline(always)]
fn within(command: f64, limit: f64) -> f64 {
    if command.abs() <= limit { 1.0 } else { 0.0 }
}

/// 1/x, and zero if that is infinite.
#[inline(always)]
fn inverse(x: f64) -> f64 {
    let inverse = 1.0 / x;
    if inverse.is_finite() { inverse } else { 0.0 }
}
