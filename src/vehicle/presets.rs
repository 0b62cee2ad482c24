//! The RexROV in numbers: UUV Simulator's description and Tables 3 to 6 of the paper.
//!
//! Corrected misprints: the mass of 1.863 kg is 1863 kg, thruster 5 points to psi = -45 deg, added
//! masses and dampings are magnitudes. Z_w stays 782.4 as in Table 6 (728.4 in the simulator), and
//! the printed buoyancy corresponds to a density of 1020 kg/m3, not 1000.

use super::{Inertia, Parameters, Propulsion, Thruster, ThrusterMode};

const ADDED_MASS: [[f64; 6]; 6] = [
    [779.79, -6.8773, -103.32, 8.5426, -165.54, -7.8033],
    [-6.8773, 1222.0, 51.29, 409.44, -5.8488, 62.726],
    [-103.32, 51.29, 3659.9, 6.1112, -386.42, 10.774],
    [8.5426, 409.44, 6.1112, 534.9, -10.027, 21.019],
    [-165.54, -5.8488, -386.42, -10.027, 842.69, -1.1162],
    [-7.8033, 62.726, 10.775, 21.019, -1.1162, 224.32],
];

// The simulator gives the inertia in forward-left-up axes; xy and xz change sign in FRD.
const INERTIA: Inertia =
    Inertia { xx: 525.39, yy: 794.20, zz: 691.23, xy: -1.44, xz: -33.41, yz: 2.6 };

pub(super) fn uuv() -> Parameters {
    Parameters {
        mass: 1862.87,
        inertia: INERTIA,
        volume: 1.83826,
        density: 1028.0,
        gravity: 9.81,
        buoyancy: None,
        centre_of_buoyancy: [0.0, 0.0, -0.3],
        added_mass: ADDED_MASS,
        linear_damping: [74.82, 69.48, 728.4, 268.8, 309.77, 105.0],
        quadratic_damping: [748.22, 992.53, 1821.01, 672.0, 774.44, 523.27],
        propulsion: Propulsion::default(),
    }
}

pub(super) fn uuv_diagonal() -> Parameters {
    let diagonal = core::array::from_fn(|i| {
        core::array::from_fn(|j| if i == j { ADDED_MASS[i][i] } else { 0.0 })
    });
    let inertia = Inertia { xy: 0.0, xz: 0.0, yz: 0.0, ..INERTIA };
    Parameters { inertia, added_mass: diagonal, ..uuv() }
}

pub(super) fn paper() -> Parameters {
    Parameters {
        mass: 1863.0,
        density: 1020.0,
        buoyancy: Some(18393.9972),
        linear_damping: [74.82, 69.48, 782.4, 268.8, 309.77, 105.0],
        ..uuv_diagonal()
    }
}

const fn thruster(lx: f64, ly: f64, lz: f64, theta_deg: f64, psi_deg: f64) -> Thruster {
    Thruster { lx, ly, lz, theta_deg, psi_deg }
}

/// Tables 3 and 4: four near-vertical, four horizontal at 45 degrees.
const THRUSTERS: [Thruster; 8] = [
    thruster(-0.890895, 0.334385, -0.528822, 74.53, -53.21),
    thruster(-0.890895, -0.334385, -0.528822, 74.53, 53.21),
    thruster(0.890895, 0.334385, -0.528822, 105.47, 53.21),
    thruster(0.890895, -0.334385, -0.528822, 105.47, -53.21),
    thruster(-0.412125, 0.505415, -0.129, 0.0, 45.0),
    thruster(-0.412125, -0.505415, -0.129, 0.0, -45.0),
    thruster(0.412125, 0.505415, -0.129, 0.0, 135.0),
    thruster(0.412125, -0.505415, -0.129, 0.0, -135.0),
];

impl Default for Propulsion {
    fn default() -> Self {
        Self {
            thrusters: THRUSTERS,
            mode: ThrusterMode::ForceWithLag,
            rotor_time_constant: 0.05,
            thrust_gain: 0.00031,
            thrust_limit: 2000.0,
        }
    }
}
