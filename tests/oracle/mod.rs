//! An independent implementation of the vehicle, for any number type: Fossen's equation as the
//! module `rexrov::vehicle` gives it, with rigid body and added mass separate, sharing no code with
//! the product. Coefficients are numbers like all others, so that dual numbers run through them
//! too.

mod draw;
mod flat;

use num_dual::DualNum;
use rexrov::vehicle::{Parameters, ThrusterMode};

pub(crate) use draw::Draw;
use flat::cut;
pub(crate) use flat::*;

/// Coefficients as numbers of any type.
struct Coefficients<D> {
    mode: ThrusterMode,
    mass: D,
    inertia: [[D; 3]; 3],
    gravity: D,
    buoyancy: D,
    centre_of_buoyancy: [D; 3],
    added_mass: [[D; 6]; 6],
    linear_damping: [D; 6],
    quadratic_damping: [D; 6],
    /// lx, ly, lz (m), theta, psi (deg) of each.
    thrusters: [[D; 5]; 8],
    rotor_time_constant: D,
    thrust_gain: D,
    thrust_limit: D,
}

impl<D: DualNum<Primitive = f64> + Copy> Coefficients<D> {
    fn new(c: &[D; COEFFICIENTS], like: &Parameters) -> Self {
        let [xx, yy, zz, xy, xz, yz] = cut(c, 1);
        let [volume, density, gravity, buoyancy] = cut(c, 7);
        let a = |i: usize, j: usize| c[14 + 6 * i + j];
        Self {
            mode: like.propulsion.mode,
            mass: c[0],
            inertia: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
            gravity,
            buoyancy: if like.buoyancy.is_some() { buoyancy } else { density * gravity * volume },
            centre_of_buoyancy: cut(c, 11),
            added_mass: core::array::from_fn(|i| {
                core::array::from_fn(|j| (a(i, j) + a(j, i)) * 0.5)
            }),
            linear_damping: cut(c, 50),
            quadratic_damping: cut(c, 56),
            thrusters: core::array::from_fn(|i| cut(c, 62 + 5 * i)),
            rotor_time_constant: c[102],
            thrust_gain: c[103],
            thrust_limit: c[104],
        }
    }

    /// Rigid body and added mass.
    fn mass_matrix(&self) -> [[D; 6]; 6] {
        let mut m = self.added_mass;
        for i in 0..3 {
            m[i][i] += self.mass;
            for j in 0..3 {
                m[3 + i][3 + j] += self.inertia[i][j];
            }
        }
        m
    }
}

/// Solves m x = b by elimination; m is positive definite, so no pivoting.
fn solve<D: DualNum<Primitive = f64> + Copy>(mut m: [[D; 6]; 6], mut b: [D; 6]) -> [D; 6] {
    for k in 0..6 {
        for i in k + 1..6 {
            let factor = m[i][k] / m[k][k];
            (k..6).for_each(|j| m[i][j] -= factor * m[k][j]);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..6).rev() {
        let rest: D = (k + 1..6).map(|j| m[k][j] * b[j]).sum();
        b[k] = (b[k] - rest) / m[k][k];
    }
    b
}

fn cross<D: DualNum<Primitive = f64> + Copy>(a: [D; 3], b: [D; 3]) -> [D; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn times<D: DualNum<Primitive = f64> + Copy, const N: usize>(m: &[[D; N]; N], a: [D; N]) -> [D; N] {
    core::array::from_fn(|i| (0..N).map(|j| a[j] * m[i][j]).sum())
}

fn clip<D: DualNum<Primitive = f64> + Copy>(x: D, limit: D) -> D {
    if x.re() > limit.re() {
        limit
    } else if x.re() < -limit.re() {
        -limit
    } else {
        x
    }
}

/// Rotor speed that gives a thrust.
fn speed_of<D: DualNum<Primitive = f64> + Copy>(thrust: D, gain: D) -> D {
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
    p: &Coefficients<D>,
    nu: [D; 6],
    r: &[[D; 3]; 3],
    thrust: [D; 8],
    u: &[D; IN],
) -> [D; 6] {
    let (v, omega): ([D; 3], [D; 3]) = (cut(&nu, 0), cut(&nu, 3));
    let current: [D; 3] = core::array::from_fn(|j| (0..3).map(|i| r[i][j] * u[22 + i]).sum());
    let nu_r: [D; 6] = core::array::from_fn(|i| if i < 3 { nu[i] - current[i] } else { nu[i] });
    let mut tau: [D; 6] = cut(u, 16);
    for ([lx, ly, lz, theta, psi], t) in p.thrusters.into_iter().zip(thrust) {
        let [theta, psi] = [theta, psi].map(|degrees| degrees * 1.0_f64.to_radians());
        let axis = [theta.cos() * psi.cos(), theta.cos() * psi.sin(), -theta.sin()];
        let moment = cross([lx, ly, lz], axis);
        (0..3).for_each(|i| tau[i] += t * axis[i]);
        (0..3).for_each(|i| tau[3 + i] += t * moment[i]);
    }
    let a = p.added_mass;
    let (spin, momentum) = (times(&p.inertia, omega), times(&a, nu_r));
    let (p_a, h_a) = (cut(&momentum, 0), cut(&momentum, 3));
    let turn = cross(omega, current);
    let carried = times(&a, [turn[0], turn[1], turn[2], D::zero(), D::zero(), D::zero()]);
    let up = [-r[2][0], -r[2][1], -r[2][2]];
    let moment_of_buoyancy = cross(p.centre_of_buoyancy, up);
    for i in 0..3 {
        tau[i] -= cross(omega, v)[i] * p.mass + cross(omega, p_a)[i];
        tau[i] += up[i] * (p.buoyancy - p.mass * p.gravity);
        tau[3 + i] -= cross(omega, spin)[i] + cross(omega, h_a)[i] + cross(cut(&nu_r, 0), p_a)[i];
        tau[3 + i] += moment_of_buoyancy[i] * p.buoyancy;
    }
    for i in 0..6 {
        tau[i] -= nu_r[i] * p.linear_damping[i] + nu_r[i] * nu_r[i].abs() * p.quadratic_damping[i];
        tau[i] -= carried[i];
    }
    solve(p.mass_matrix(), tau)
}

/// Derivative of the state and outputs, for a vehicle with these coefficients and otherwise `like`.
pub(crate) fn model<D: DualNum<Primitive = f64> + Copy>(
    like: &Parameters,
    c: &[D; COEFFICIENTS],
    x: &[D; STATE],
    u: &[D; IN],
) -> ([D; STATE], [D; OUT]) {
    let (q, nu, rotor): ([D; 4], [D; 6], [D; 8]) = (cut(x, 3), cut(x, 7), cut(x, 13));
    let (v, omega): ([D; 3], [D; 3]) = (cut(&nu, 0), cut(&nu, 3));
    let p = &Coefficients::new(c, like);
    let (gain, limit) = (p.thrust_gain, p.thrust_limit);
    let lagged = |target: D, i: usize| (target - rotor[i]) / p.rotor_time_constant;
    let demanded: [D; 8] = core::array::from_fn(|i| match p.mode {
        ThrusterMode::RotorSpeed => clip(u[8 + i], (limit / gain).sqrt()),
        _ => speed_of(clip(u[i], limit), gain),
    });
    let (speed, rotor_dot): ([D; 8], [D; 8]) = match p.mode {
        ThrusterMode::Force => (demanded, [D::zero(); 8]),
        _ => (rotor, core::array::from_fn(|i| lagged(demanded[i], i))),
    };
    let thrust: [D; 8] = core::array::from_fn(|i| {
        let w = speed[i];
        let sound =
            if p.mode == ThrusterMode::Force { clip(u[i], limit) } else { w * w.abs() * gain };
        sound - sound * u[25 + i]
    });
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
    let outputs = [&x[..3], &euler, &unit, &nu, &nu_dot, &v_ned, &felt, &thrust, &speed].concat();
    (cut(&rate, 0), cut(&outputs, 0))
}
