//! The vehicle stated a second time, for any number type: Fossen's equation as the module
//! `rexrov::vehicle` prints it, rigid body and added mass apart, nothing shared with the product.
//! And random vehicles, states and inputs as flat arrays.

use nalgebra::Matrix6;
use num_dual::DualNum;
use rexrov::vehicle::{
    Inertia, Inputs, Outputs, Parameters, Propulsion, State, Thruster, ThrusterMode,
};

pub(crate) const STATE: usize = 21;
pub(crate) const IN: usize = 25;
pub(crate) const OUT: usize = 36;
/// Position, quaternion, linear and angular velocity, rotors.
pub(crate) const STATE_GROUPS: [usize; 5] = [3, 4, 3, 3, 8];
/// Position, angles, quaternion, nu, nu_dot (linear and angular), v_ned, specific force, thrust.
pub(crate) const OUT_GROUPS: [usize; 10] = [3, 3, 4, 3, 3, 3, 3, 3, 3, 8];

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
];

pub(crate) fn flat_state(x: &State) -> [f64; STATE] {
    let flat = [&x.p_ned[..], &x.quaternion, &x.nu, &x.rotor_speed].concat();
    flat.try_into().unwrap()
}

pub(crate) fn state_of(x: &[f64; STATE]) -> State {
    State { p_ned: cut(x, 0), quaternion: cut(x, 3), nu: cut(x, 7), rotor_speed: cut(x, 13) }
}

pub(crate) fn flat_inputs(u: &Inputs) -> [f64; IN] {
    let flat = [&u.thruster_force[..], &u.thruster_speed, &u.wrench, &u.current_ned].concat();
    flat.try_into().unwrap()
}

pub(crate) fn inputs_of(u: &[f64; IN]) -> Inputs {
    Inputs {
        thruster_force: cut(u, 0),
        thruster_speed: cut(u, 8),
        wrench: cut(u, 16),
        current_ned: cut(u, 22),
    }
}

pub(crate) fn flat_outputs(y: &Outputs) -> [f64; OUT] {
    let pose = [&y.p_ned[..], &y.euler, &y.quaternion].concat();
    let rest = [&y.nu[..], &y.nu_dot, &y.v_ned, &y.specific_force, &y.thrust].concat();
    [pose, rest].concat().try_into().unwrap()
}

fn cut<T: Copy, const N: usize>(a: &[T], begin: usize) -> [T; N] {
    core::array::from_fn(|i| a[begin + i])
}

fn cross<D: DualNum<Primitive = f64> + Copy>(a: [D; 3], b: [D; 3]) -> [D; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn times<D: DualNum<Primitive = f64> + Copy, const N: usize>(
    m: &[[f64; N]; N],
    a: [D; N],
) -> [D; N] {
    core::array::from_fn(|i| (0..N).map(|j| a[j] * m[i][j]).sum())
}

fn clip<D: DualNum<Primitive = f64> + Copy>(x: D, limit: f64) -> D {
    if x > limit {
        D::from(limit)
    } else if x < -limit {
        D::from(-limit)
    } else {
        x
    }
}

/// Rotor speed that gives a thrust.
fn speed_of<D: DualNum<Primitive = f64> + Copy>(thrust: D, gain: f64) -> D {
    (thrust.abs() / gain).sqrt() * thrust.signum()
}

/// R (body to NED) of a quaternion of any length: homogeneous form over the squared length.
fn rotation<D: DualNum<Primitive = f64> + Copy>([w, x, y, z]: [D; 4]) -> [[D; 3]; 3] {
    let n = w * w + x * x + y * y + z * z;
    let two = 2.0;
    [
        [w * w + x * x - y * y - z * z, (x * y - w * z) * two, (x * z + w * y) * two],
        [(x * y + w * z) * two, w * w - x * x + y * y - z * z, (y * z - w * x) * two],
        [(x * z - w * y) * two, (y * z + w * x) * two, w * w - x * x - y * y + z * z],
    ]
    .map(|row| row.map(|e| e / n))
}

/// nu' with all forces one after the other.
fn acceleration<D: DualNum<Primitive = f64> + Copy>(
    p: &Parameters,
    nu: [D; 6],
    r: &[[D; 3]; 3],
    thrust: [D; 8],
    u: &[D; IN],
) -> [D; 6] {
    let (v, omega): ([D; 3], [D; 3]) = (cut(&nu, 0), cut(&nu, 3));
    let current: [D; 3] = core::array::from_fn(|j| (0..3).map(|i| r[i][j] * u[22 + i]).sum());
    let nu_r: [D; 6] = core::array::from_fn(|i| if i < 3 { nu[i] - current[i] } else { nu[i] });
    let mut tau: [D; 6] = cut(u, 16);
    for (thruster, t) in p.propulsion.thrusters.iter().zip(thrust) {
        let (theta, psi) = (thruster.theta_deg.to_radians(), thruster.psi_deg.to_radians());
        let axis = [theta.cos() * psi.cos(), theta.cos() * psi.sin(), -theta.sin()];
        let moment = cross([thruster.lx, thruster.ly, thruster.lz], axis);
        (0..3).for_each(|i| tau[i] += t * axis[i]);
        (0..3).for_each(|i| tau[3 + i] += t * moment[i]);
    }
    let a = p.symmetric_added_mass();
    let (spin, momentum) = (times(&p.inertia.matrix(), omega), times(&a, nu_r));
    let (p_a, h_a) = (cut(&momentum, 0), cut(&momentum, 3));
    let turn = cross(omega, current);
    let carried = times(&a, [turn[0], turn[1], turn[2], D::zero(), D::zero(), D::zero()]);
    let up = [-r[2][0], -r[2][1], -r[2][2]];
    let moment_of_buoyancy = cross(p.centre_of_buoyancy.map(D::from), up);
    for i in 0..3 {
        tau[i] -= cross(omega, v)[i] * p.mass + cross(omega, p_a)[i];
        tau[i] += up[i] * (p.buoyancy_force() - p.weight());
        tau[3 + i] -= cross(omega, spin)[i] + cross(omega, h_a)[i] + cross(cut(&nu_r, 0), p_a)[i];
        tau[3 + i] += moment_of_buoyancy[i] * p.buoyancy_force();
    }
    for i in 0..6 {
        tau[i] -= nu_r[i] * p.linear_damping[i] + nu_r[i] * nu_r[i].abs() * p.quadratic_damping[i];
        tau[i] -= carried[i];
    }
    let m = p.mass_matrix();
    let inverse = Matrix6::from_fn(|i, j| m[i][j]).try_inverse().unwrap();
    times(&core::array::from_fn(|i| core::array::from_fn(|j| inverse[(i, j)])), tau)
}

/// Derivative of the state and outputs.
pub(crate) fn model<D: DualNum<Primitive = f64> + Copy>(
    p: &Parameters,
    x: &[D; STATE],
    u: &[D; IN],
) -> ([D; STATE], [D; OUT]) {
    let (q, nu, rotor): ([D; 4], [D; 6], [D; 8]) = (cut(x, 3), cut(x, 7), cut(x, 13));
    let (v, omega): ([D; 3], [D; 3]) = (cut(&nu, 0), cut(&nu, 3));
    let thrusters = &p.propulsion;
    let (gain, limit) = (thrusters.thrust_gain, thrusters.thrust_limit);
    let lagged = |target: D, i: usize| (target - rotor[i]) / thrusters.rotor_time_constant;
    let (thrust, rotor_dot): ([D; 8], [D; 8]) = match thrusters.mode {
        ThrusterMode::Force => (core::array::from_fn(|i| clip(u[i], limit)), [D::zero(); 8]),
        mode => (
            rotor.map(|w| w * w.abs() * gain),
            core::array::from_fn(|i| match mode {
                ThrusterMode::RotorSpeed => lagged(clip(u[8 + i], (limit / gain).sqrt()), i),
                _ => lagged(speed_of(clip(u[i], limit), gain), i),
            }),
        ),
    };
    let r = rotation(q);
    let nu_dot = acceleration(p, nu, &r, thrust, u);
    let v_ned: [D; 3] = core::array::from_fn(|i| (0..3).map(|j| r[i][j] * v[j]).sum());
    let norm2: D = q.iter().map(|c| *c * *c).sum();
    // q (0, omega) with the product rule of scalar and vector part.
    let (scalar, axis) = (q[0], [q[1], q[2], q[3]]);
    let twist = cross(axis, omega);
    let dot: D = (0..3).map(|i| axis[i] * omega[i]).sum();
    let q_dot: [D; 4] = core::array::from_fn(|i| {
        let spin = if i == 0 { -dot } else { scalar * omega[i - 1] + twist[i - 1] };
        (spin + q[i] * (D::one() - norm2)) * 0.5
    });
    let euler = [r[2][1].atan2(r[2][2]), (-r[2][0]).asin(), r[1][0].atan2(r[0][0])];
    let felt: [D; 3] =
        core::array::from_fn(|i| nu_dot[i] + cross(omega, v)[i] - r[2][i] * p.gravity);
    let unit = q.map(|c| c / norm2.sqrt());
    let rate = [&v_ned[..], &q_dot, &nu_dot, &rotor_dot].concat();
    let outputs = [&x[..3], &euler, &unit, &nu, &nu_dot, &v_ned, &felt, &thrust].concat();
    (cut(&rate, 0), cut(&outputs, 0))
}

/// Takes one number in (-1, 1) after the other.
pub(crate) struct Draw<'a>(core::slice::Iter<'a, f64>);

impl<'a> Draw<'a> {
    pub(crate) fn new(numbers: &'a [f64]) -> Self {
        Self(numbers.iter())
    }

    pub(crate) fn array<const N: usize>(&mut self, size: f64) -> [f64; N] {
        core::array::from_fn(|_| size * self.0.next().unwrap())
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + 0.5 * (high - low) * (1.0 + self.0.next().unwrap())
    }

    /// A symmetric positive definite matrix with eigenvalues of at least `least`.
    fn definite<const N: usize>(&mut self, size: f64, least: f64) -> [[f64; N]; N] {
        let g: [[f64; N]; N] = core::array::from_fn(|_| self.array(size.sqrt()));
        core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let product: f64 = (0..N).map(|k| g[i][k] * g[j][k]).sum();
                product + if i == j { least } else { 0.0 }
            })
        })
    }

    pub(crate) fn parameters(&mut self, mode: ThrusterMode) -> Parameters {
        let i = self.definite::<3>(300.0, 200.0);
        let positive = |draw: &mut Self, high| core::array::from_fn(|_| draw.between(0.0, high));
        let inertia = Inertia {
            xx: i[0][0],
            yy: i[1][1],
            zz: i[2][2],
            xy: i[0][1],
            xz: i[0][2],
            yz: i[1][2],
        };
        Parameters {
            mass: self.between(500.0, 3000.0),
            inertia,
            volume: self.between(0.5, 3.0),
            density: self.between(990.0, 1030.0),
            gravity: self.between(9.0, 10.0),
            buoyancy: None,
            centre_of_buoyancy: self.array(0.4),
            added_mass: self.definite(800.0, 200.0),
            linear_damping: positive(self, 500.0),
            quadratic_damping: positive(self, 1500.0),
            propulsion: self.propulsion(mode),
        }
    }

    fn propulsion(&mut self, mode: ThrusterMode) -> Propulsion {
        let thrusters = core::array::from_fn(|_| {
            let [lx, ly, lz] = self.array(1.0);
            let [theta_deg, psi_deg] = self.array(180.0);
            Thruster { lx, ly, lz, theta_deg, psi_deg }
        });
        Propulsion {
            thrusters,
            mode,
            rotor_time_constant: self.between(0.02, 0.5),
            thrust_gain: self.between(1e-4, 1e-3),
            thrust_limit: self.between(500.0, 2500.0),
        }
    }

    /// Any attitude but steep pitch, where the Euler angles are ill conditioned; a quaternion that
    /// is not of unit length.
    pub(crate) fn state(&mut self) -> [f64; STATE] {
        let [roll, yaw] = self.array(3.1);
        let attitude = [roll, self.between(-1.2, 1.2), yaw];
        let length = self.between(0.8, 1.2);
        let x = State::at_rest(self.array(30.0), attitude);
        flat_state(&State {
            quaternion: x.quaternion.map(|c| c * length),
            nu: self.array(1.5),
            rotor_speed: self.array(900.0),
            ..x
        })
    }

    /// Commands within and beyond their limits, but near neither them nor zero.
    pub(crate) fn inputs(&mut self, p: &Propulsion) -> [f64; IN] {
        let mut command = |limit: f64| {
            self.array(2.0).map(|c: f64| {
                let size = if c.abs() < 1.0 { 0.05 + 0.85 * c.abs() } else { c.abs() + 0.1 };
                limit * size.copysign(c)
            })
        };
        let (force, speed) = (command(p.thrust_limit), command(p.speed(p.thrust_limit)));
        flat_inputs(&Inputs {
            thruster_force: force,
            thruster_speed: speed,
            wrench: self.array(500.0),
            current_ned: self.array(1.0),
        })
    }
}
