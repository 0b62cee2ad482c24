//! State, inputs and outputs of the vehicle model. World NED, body FRD, SI units.

use crate::attitude;

/// Continuous state, and in the same shape its time derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Position of the centre of gravity, NED (m).
    pub p_ned: [f64; 3],
    /// Attitude `[w, x, y, z]`, body to NED; its length stays near one, but no code relies on it.
    pub quaternion: [f64; 4],
    /// Velocity over ground `[u, v, w, p, q, r]`, body (m/s, rad/s).
    pub nu: [f64; 6],
    /// Rotor speeds (rad/s).
    pub rotor_speed: [f64; 8],
}

impl State {
    /// No change.
    pub const ZERO: Self =
        Self { p_ned: [0.0; 3], quaternion: [0.0; 4], nu: [0.0; 6], rotor_speed: [0.0; 8] };

    /// At rest, rotors stopped, at a position and an attitude `[roll, pitch, yaw]` (rad).
    #[must_use]
    pub fn at_rest(p_ned: [f64; 3], euler: [f64; 3]) -> Self {
        Self { p_ned, quaternion: attitude::from_euler(euler), nu: [0.0; 6], rotor_speed: [0.0; 8] }
    }

    /// Change of [`State::at_rest`] at an attitude as position and attitude change.
    #[must_use]
    pub fn d_at_rest(d_p_ned: [f64; 3], euler: [f64; 3], d_euler: [f64; 3]) -> Self {
        Self { p_ned: d_p_ned, quaternion: attitude::d_from_euler(euler, d_euler), ..Self::ZERO }
    }
}

impl Default for State {
    fn default() -> Self {
        Self::at_rest([0.0; 3], [0.0; 3])
    }
}

/// Inputs of the vehicle; held constant over an integration step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Commanded thrusts (N), used by `ForceWithLag` and `Force`.
    pub thruster_force: [f64; 8],
    /// Commanded rotor speeds (rad/s), used by `RotorSpeed`.
    pub thruster_speed: [f64; 8],
    /// Fraction of the thrust that each propeller loses: 0 intact, 1 lost, 2 turning the wrong way.
    pub thruster_loss: [f64; 8],
    /// External wrench `[X, Y, Z, K, M, N]` about the centre of gravity, body (N, N.m).
    pub wrench: [f64; 6],
    /// Steady, irrotational current, NED (m/s).
    pub current_ned: [f64; 3],
}

/// Observable quantities of the vehicle, without sensor errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outputs {
    /// Position of the centre of gravity, NED (m).
    pub p_ned: [f64; 3],
    /// Roll, pitch and yaw (rad).
    pub euler: [f64; 3],
    /// Attitude `[w, x, y, z]`, body to NED, of unit length.
    pub quaternion: [f64; 4],
    /// Velocity over ground, body (m/s, rad/s).
    pub nu: [f64; 6],
    /// Velocity over ground, NED (m/s).
    pub v_ned: [f64; 3],
    /// Time derivative of `nu` (not the inertial acceleration), body (m/s2, rad/s2).
    pub nu_dot: [f64; 6],
    /// Specific force at the centre of gravity, body (m/s2): at rest -g on z.
    pub specific_force: [f64; 3],
    /// Thrust of each thruster (N).
    pub thrust: [f64; 8],
    /// Speed of each rotor (rad/s); in the mode without lag, the speed at which an intact propeller
    /// makes the commanded force.
    pub rotor_speed: [f64; 8],
}
