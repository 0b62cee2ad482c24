//! Coefficients, state, inputs and outputs as flat arrays, and the names of their elements.

use rexrov::vehicle::{Inertia, Inputs, Outputs, Parameters, Propulsion, State, Thruster};

pub(crate) const STATE: usize = 21;
pub(crate) const IN: usize = 33;
pub(crate) const OUT: usize = 44;
pub(crate) const COEFFICIENTS: usize = 105;
/// Position, quaternion, linear and angular velocity, rotors.
pub(crate) const STATE_GROUPS: [usize; 5] = [3, 4, 3, 3, 8];
/// Position, angles, quaternion, nu, nu_dot (linear and angular), v_ned, specific force, thrust,
/// rotor speed.
pub(crate) const OUT_GROUPS: [usize; 11] = [3, 3, 4, 3, 3, 3, 3, 3, 3, 8, 8];

/// Derivatives of the states, then outputs.
pub(crate) const NAMES: [&str; STATE + OUT] = [
    "x'",
    "y'",
    "z'",
    "qw'",
    "qx'",
    "qy'",
    "qz'",
    "u'",
    "v'",
    "w'",
    "p'",
    "q'",
    "r'",
    "rotor[0]'",
    "rotor[1]'",
    "rotor[2]'",
    "rotor[3]'",
    "rotor[4]'",
    "rotor[5]'",
    "rotor[6]'",
    "rotor[7]'",
    "p_ned[0]",
    "p_ned[1]",
    "p_ned[2]",
    "roll",
    "pitch",
    "yaw",
    "qw",
    "qx",
    "qy",
    "qz",
    "nu[0]",
    "nu[1]",
    "nu[2]",
    "nu[3]",
    "nu[4]",
    "nu[5]",
    "nu_dot[0]",
    "nu_dot[1]",
    "nu_dot[2]",
    "nu_dot[3]",
    "nu_dot[4]",
    "nu_dot[5]",
    "v_ned[0]",
    "v_ned[1]",
    "v_ned[2]",
    "specific_force[0]",
    "specific_force[1]",
    "specific_force[2]",
    "thrust[0]",
    "thrust[1]",
    "thrust[2]",
    "thrust[3]",
    "thrust[4]",
    "thrust[5]",
    "thrust[6]",
    "thrust[7]",
    "rotor_speed[0]",
    "rotor_speed[1]",
    "rotor_speed[2]",
    "rotor_speed[3]",
    "rotor_speed[4]",
    "rotor_speed[5]",
    "rotor_speed[6]",
    "rotor_speed[7]",
];

pub(crate) fn flat_state(x: &State) -> [f64; STATE] {
    let flat = [&x.p_ned[..], &x.quaternion, &x.nu, &x.rotor_speed].concat();
    flat.try_into().unwrap()
}

pub(crate) fn state_of(x: &[f64; STATE]) -> State {
    State { p_ned: cut(x, 0), quaternion: cut(x, 3), nu: cut(x, 7), rotor_speed: cut(x, 13) }
}

pub(crate) fn flat_inputs(u: &Inputs) -> [f64; IN] {
    let thrusters = [u.thruster_force, u.thruster_speed].concat();
    let around = [&u.wrench[..], &u.current_ned, &u.thruster_loss].concat();
    [thrusters, around].concat().try_into().unwrap()
}

pub(crate) fn inputs_of(u: &[f64; IN]) -> Inputs {
    Inputs {
        thruster_force: cut(u, 0),
        thruster_speed: cut(u, 8),
        wrench: cut(u, 16),
        current_ned: cut(u, 22),
        thruster_loss: cut(u, 25),
    }
}

pub(crate) fn flat_outputs(y: &Outputs) -> [f64; OUT] {
    let pose = [&y.p_ned[..], &y.euler, &y.quaternion].concat();
    let rest = [&y.nu[..], &y.nu_dot, &y.v_ned, &y.specific_force].concat();
    [pose, rest, [y.thrust, y.rotor_speed].concat()].concat().try_into().unwrap()
}

/// The numbers among the coefficients; no buoyancy is zero.
pub(crate) fn flat_parameters(p: &Parameters) -> [f64; COEFFICIENTS] {
    let i = &p.inertia;
    let body = [p.mass, i.xx, i.yy, i.zz, i.xy, i.xz, i.yz];
    let water = [p.volume, p.density, p.gravity, p.buoyancy.unwrap_or_default()];
    let damping = [p.linear_damping, p.quadratic_damping].concat();
    let places =
        p.propulsion.thrusters.iter().flat_map(|t| [t.lx, t.ly, t.lz, t.theta_deg, t.psi_deg]);
    let p_t = &p.propulsion;
    let rotor = [p_t.rotor_time_constant, p_t.thrust_gain, p_t.thrust_limit];
    let all = [&body[..], &water, &p.centre_of_buoyancy, p.added_mass.as_flattened(), &damping];
    all.concat().into_iter().chain(places).chain(rotor).collect::<Vec<_>>().try_into().unwrap()
}

/// Coefficients with these numbers, the rest as in `like`.
pub(crate) fn parameters_of(c: &[f64; COEFFICIENTS], like: &Parameters) -> Parameters {
    let [xx, yy, zz, xy, xz, yz] = cut(c, 1);
    Parameters {
        mass: c[0],
        inertia: Inertia { xx, yy, zz, xy, xz, yz },
        volume: c[7],
        density: c[8],
        gravity: c[9],
        buoyancy: like.buoyancy.map(|_| c[10]),
        centre_of_buoyancy: cut(c, 11),
        added_mass: core::array::from_fn(|i| cut(c, 14 + 6 * i)),
        linear_damping: cut(c, 50),
        quadratic_damping: cut(c, 56),
        propulsion: Propulsion {
            thrusters: core::array::from_fn(|i| {
                let [lx, ly, lz, theta_deg, psi_deg] = cut(c, 62 + 5 * i);
                Thruster { lx, ly, lz, theta_deg, psi_deg }
            }),
            mode: like.propulsion.mode,
            rotor_time_constant: c[102],
            thrust_gain: c[103],
            thrust_limit: c[104],
        },
    }
}

pub(super) fn cut<T: Copy, const N: usize>(a: &[T], begin: usize) -> [T; N] {
    core::array::from_fn(|i| a[begin + i])
}
