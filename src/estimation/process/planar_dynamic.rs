//! The equations of motion in four degrees of freedom as a process: surge, sway, heave, yaw.
//!
//! ```text
//! m1 nu1' = -(d1 + D1|nu1|) nu1 + m2 nu2 r + X + dX     x' = u ct cpsi + ... (measured roll and pitch)
//! m2 nu2' = -(d2 + D2|nu2|) nu2 - m1 nu1 r + Y + dY     psi' = r cos(roll) / cos(pitch)
//! m3 nu3' = -(d3 + D3|nu3|) nu3 + (W - B) + Z + dZ      current, gyro bias: random walks
//! m6 r' = -(d6 + D6|r|) r - (a22 - a11) nu1 nu2 + N + dN    d: Ornstein-Uhlenbeck
//! u = nu + R^T c,   u' = nu' - (r e_z) x R^T c
//! ```
//! u is the velocity over ground along body axes, nu the velocity through the water, c the current.
//! The gyro is a measurement, compared with the yaw rate at the middle of its interval. Without
//! thrusts u and r are random walks set by the parameters. Eqs (27) to (30) of the paper with
//! corrected signs; Fossen (2011) ch. 7.3. The step is the midpoint rule, F its exact derivative,
//! `Q_d = (F Q F^T + Q) dt/2`.

use nalgebra::{Matrix3, Vector3};

use super::Process;
use crate::ParameterError;
use crate::attitude;
use crate::estimation::belief::{Belief, Column, Row};
use crate::estimation::interval::Interval;
use crate::estimation::kalman::{Witness, fuse};
use crate::estimation::kinematics::{Block, Kinematics, Motion, SensorStates, first_column};
use crate::estimation::lanes::midpoint;
use crate::estimation::parameters::{Disturbances, NavigationParameters};
use crate::estimation::sensor::Observation;
use crate::estimation::transition::Transition;
use crate::vehicle::Parameters;

const PSI: usize = 3;
const U: usize = 4;
const R: usize = 7;
const C: usize = 8;
const B_G: usize = 10;
const D: usize = 11;
const BASE: usize = 15;
/// States whose rates depend on others.
const MOVING: usize = 8;
/// States that rates depend on, and as many as fill whole vectors.
const MOVERS: usize = 15;
const PADDED: usize = 16;

type Rates = [f64; MOVING];
type Jacobian = [[f64; PADDED]; MOVING];

/// The four-degree-of-freedom model.
#[derive(Clone, Debug)]
pub struct PlanarDynamic {
    parameters: NavigationParameters,
    disturbances: Disturbances,
    sensors: SensorStates,
    sensor_sigmas: [(usize, f64); 4],
    order: usize,
    mass: [f64; 4],
    linear: [f64; 4],
    quadratic: [f64; 4],
    munk: f64,
    excess_weight: f64,
    thrusters: [[f64; 4]; 8],
}

/// The inputs that drive an interval.
struct Drive {
    /// Forces and yaw moment of the thrusters (N, N.m), if they are known.
    thrust: Option<[f64; 4]>,
    /// Rotation by roll and pitch, without yaw.
    tilt: Matrix3<f64>,
}

/// The vehicle in the water.
struct Afloat {
    x: [f64; MOVERS],
    /// From body to NED.
    rotation: Matrix3<f64>,
    /// The current along body axes (m/s), and its derivative by the heading.
    flow: Vector3<f64>,
    flow_by_heading: Vector3<f64>,
    /// Velocity through the water (m/s).
    nu: Vector3<f64>,
}

impl Afloat {
    fn new(x: [f64; MOVERS], tilt: &Matrix3<f64>) -> Self {
        let rotation = turned(tilt, x[PSI]);
        let flow = rotation.tr_mul(&Vector3::new(x[C], x[C + 1], 0.0));
        // The current rotates against the heading.
        let flow_by_heading = rotation.tr_mul(&Vector3::new(x[C + 1], -x[C], 0.0));
        let nu = Vector3::new(x[U], x[U + 1], x[U + 2]) - flow;
        Self { x, rotation, flow, flow_by_heading, nu }
    }

    /// Velocities of surge, sway, heave and yaw through the water.
    fn speed(&self) -> [f64; 4] {
        [self.nu.x, self.nu.y, self.nu.z, self.x[R]]
    }

    /// Velocity over ground, NED (m/s).
    fn over_ground(&self) -> Vector3<f64> {
        self.rotation * Vector3::new(self.x[U], self.x[U + 1], self.x[U + 2])
    }
}

fn movers<const N: usize>(mean: &Column<N>) -> [f64; MOVERS] {
    core::array::from_fn(|i| mean[i])
}

impl Drive {
    /// Heading rate per yaw rate.
    fn turn(&self) -> f64 {
        let [cos_roll, cos_pitch] = [self.tilt[(1, 1)], self.tilt[(0, 0)]];
        cos_roll / cos_pitch.max(0.05)
    }
}

impl PlanarDynamic {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(
        p: &NavigationParameters,
        vehicle: &Parameters,
        disturbances: &Disturbances,
    ) -> Result<Self, ParameterError> {
        p.check()?;
        vehicle.check()?;
        disturbances.check()?;
        let (sensors, sensor_sigmas, order) = p.sensors.states(BASE);
        let m = vehicle.mass_matrix();
        let pick = |d: &[f64; 6]| [d[0], d[1], d[2], d[5]];
        Ok(Self {
            parameters: *p,
            disturbances: *disturbances,
            sensors,
            sensor_sigmas,
            order,
            mass: [m[0][0], m[1][1], m[2][2], m[5][5]],
            linear: pick(&vehicle.linear_damping),
            quadratic: pick(&vehicle.quadratic_damping),
            munk: m[1][1] - m[0][0],
            excess_weight: vehicle.weight() - vehicle.buoyancy_force(),
            thrusters: vehicle.propulsion.thrusters.map(|t| pick(&t.unit_wrench())),
        })
    }

    fn drive(&self, interval: &Interval) -> Drive {
        let thrust = interval.thrust.as_ref().map(|thrusts| {
            core::array::from_fn(|axis| {
                let units = self.thrusters.iter().map(|unit| unit[axis]);
                units.zip(thrusts.mean).map(|(unit, force)| unit * force).sum()
            })
        });
        Drive { thrust, tilt: tilt(interval) }
    }

    /// Acceleration of a velocity through the water, or of the yaw rate.
    #[inline(always)]
    fn acceleration(&self, at: &Afloat, thrust: &[f64; 4], axis: usize) -> f64 {
        let (nu, r, [m1, m2, ..]) = (&at.nu, at.x[R], self.mass);
        let coupling = match axis {
            0 => m2 * nu.y * r,
            1 => -m1 * nu.x * r,
            2 => self.excess_weight,
            _ => -self.munk * nu.x * nu.y,
        };
        let speed = at.speed()[axis];
        let damping = (self.linear[axis] + self.quadratic[axis] * speed.abs()) * speed;
        (coupling - damping + thrust[axis] + at.x[D + axis]) / self.mass[axis]
    }

    /// Derivatives of [`PlanarDynamic::acceleration`] by the states.
    #[inline(always)]
    fn acceleration_by_states(&self, at: &Afloat, axis: usize) -> [f64; PADDED] {
        let (nu, r, [m1, m2, _, m6]) = (&at.nu, at.x[R], self.mass);
        // By nu and r.
        let mut slope = match axis {
            0 => [0.0, m2 * r / m1, 0.0, m2 * nu.y / m1],
            1 => [-m1 * r / m2, 0.0, 0.0, -m1 * nu.x / m2],
            2 => [0.0; 4],
            _ => [-self.munk * nu.y / m6, -self.munk * nu.x / m6, 0.0, 0.0],
        };
        let damping = self.linear[axis] + 2.0 * self.quadratic[axis] * at.speed()[axis].abs();
        slope[axis] = -damping / self.mass[axis];
        let mut row = [0.0; PADDED];
        row[U..U + 4].copy_from_slice(&slope);
        row[D + axis] = 1.0 / self.mass[axis];
        for k in 0..3 {
            (0..2).for_each(|i| row[C + i] -= slope[k] * at.rotation[(i, k)]);
            row[PSI] -= slope[k] * at.flow_by_heading[k];
        }
        row
    }

    /// Time derivatives of the dynamic states.
    fn rates(&self, at: &Afloat, drive: &Drive) -> Rates {
        let [x, y, z] = at.over_ground().into();
        let r = at.x[R];
        let mut rates = [x, y, z, r * drive.turn(), 0.0, 0.0, 0.0, 0.0];
        let Some(thrust) = &drive.thrust else { return rates };
        (0..4).for_each(|axis| rates[U + axis] = self.acceleration(at, thrust, axis));
        // u' = nu' - (r e_z) x (R^T c).
        rates[U] += r * at.flow.y;
        rates[U + 1] -= r * at.flow.x;
        rates
    }

    /// Derivatives of [`PlanarDynamic::rates`] by the states.
    fn jacobian(&self, at: &Afloat, drive: &Drive) -> Jacobian {
        let mut j = [[0.0; PADDED]; MOVING];
        for (i, row) in j.iter_mut().take(3).enumerate() {
            (0..3).for_each(|k| row[U + k] = at.rotation[(i, k)]);
        }
        let velocity = at.over_ground();
        j[0][PSI] = -velocity.y;
        j[1][PSI] = velocity.x;
        j[PSI][R] = drive.turn();
        if drive.thrust.is_none() {
            return j;
        }
        (0..4).for_each(|axis| j[U + axis] = self.acceleration_by_states(at, axis));
        let r = at.x[R];
        j[U][R] += at.flow.y;
        j[U + 1][R] -= at.flow.x;
        j[U][PSI] += r * at.flow_by_heading.y;
        j[U + 1][PSI] -= r * at.flow_by_heading.x;
        for i in 0..2 {
            j[U][C + i] += r * at.rotation[(i, 1)];
            j[U + 1][C + i] -= r * at.rotation[(i, 0)];
        }
        j
    }

    /// Midpoint step: the change of the dynamic states; sets F, which is the identity before.
    fn step<const N: usize>(
        &self,
        mean: &Column<N>,
        drive: &Drive,
        [dt, decay]: [f64; 2],
        f: &mut Transition<N>,
    ) -> Rates {
        let first = Afloat::new(movers(mean), &drive.tilt);
        let mut middle = first.x;
        for (x, rate) in middle.iter_mut().zip(self.rates(&first, drive)) {
            *x += 0.5 * dt * rate;
        }
        let middle = Afloat::new(middle, &drive.tilt);
        let mut change = self.jacobian(&middle, drive);
        midpoint(&mut change, &self.jacobian(&first, drive), dt);
        // No rate depends on the position or the bias.
        let movers = (1 << MOVERS) - (1 << PSI) - (1 << B_G);
        for first in (0..MOVING).step_by(3) {
            let size = (MOVING - first).min(3);
            let own = ((1 << size) - 1) << first;
            let group = f.add_group(first, size, own | movers);
            for (i, row) in group.states().zip(&mut group.rows) {
                row[..PADDED].copy_from_slice(&change[i]);
                row[i] += 1.0;
            }
        }
        (0..4).for_each(|axis| f.scale(D + axis, decay));
        self.rates(&middle, drive).map(|rate| rate * dt)
    }

    /// Adds half of the process noise of an interval.
    fn add_half_noise<const N: usize>(&self, belief: &mut Belief<N>, drive: &Drive, dt: f64) {
        let d = &self.disturbances;
        let square = |x: f64| x * x;
        let half = 0.5 * dt;
        for axis in 0..4 {
            let yaw = axis == 3;
            let white = match (drive.thrust.is_some(), yaw) {
                (true, false) => d.force_density / self.mass[axis],
                (true, true) => d.moment_density / self.mass[axis],
                (false, false) => self.parameters.maneuver_acceleration,
                (false, true) => self.parameters.maneuver_rate,
            };
            belief.add_noise(U + axis, square(white) * half);
            let sigma = if yaw { d.moment_sigma } else { d.force_sigma };
            belief.add_noise(D + axis, 2.0 * square(sigma) / d.correlation_time * half);
        }
        for i in 0..2 {
            belief.add_noise(C + i, square(d.current_walk) * half);
        }
        belief.add_noise(B_G, square(self.parameters.sensors.gyro.random_walk) * half);
    }

    /// The yaw rate from successive attitudes, without a gyro.
    fn turn<const N: usize>(&self, belief: &Belief<N>, rate: f64) -> Observation<N> {
        let mut row = Row::zeros();
        row[R] = 1.0;
        let sigma = self.parameters.maneuver_rate;
        Observation::scalar(rate - belief.mean[R], row, sigma * sigma)
    }

    /// The gyro's mean compared with the yaw rate at the middle of its interval.
    #[must_use]
    pub fn gyro<const N: usize>(
        &self,
        belief: &Belief<N>,
        interval: &Interval,
        rate: f64,
    ) -> Observation<N> {
        let drive = self.drive(interval);
        let now = Afloat::new(movers(&belief.mean), &drive.tilt);
        let half = 0.5 * interval.dt;
        let mut row = Row::zeros();
        let mut predicted = now.x[R];
        if let Some(thrust) = &drive.thrust {
            let by_states = self.acceleration_by_states(&now, 3);
            for (state, by) in by_states.into_iter().enumerate().filter(|(_, by)| *by != 0.0) {
                row[state] = -half * by;
            }
            predicted -= half * self.acceleration(&now, thrust, 3);
        }
        row[R] += 1.0;
        row[B_G] += 1.0;
        predicted += now.x[B_G];
        let density = self.parameters.sensors.gyro.noise_density;
        let variance = density * density / interval.dt + GYRO_FLOOR;
        Observation::scalar(rate - predicted, row, variance)
    }
}

/// Rotation by roll and pitch.
fn tilt(interval: &Interval) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| interval.tilt[i][j])
}

/// The same with a heading.
fn turned(tilt: &Matrix3<f64>, heading: f64) -> Matrix3<f64> {
    let (sin, cos) = libm::sincos(heading);
    let mut rotation = *tilt;
    for j in 0..3 {
        rotation[(0, j)] = cos * tilt[(0, j)] - sin * tilt[(1, j)];
        rotation[(1, j)] = sin * tilt[(0, j)] + cos * tilt[(1, j)];
    }
    rotation
}

/// Minimum variance of a gyro's mean ((rad/s)^2).
const GYRO_FLOOR: f64 = 1e-14;
/// NIS at which the influence of the gyro is limited.
const GYRO_GATE: f64 = 25.0;

impl<const N: usize> Process<N> for PlanarDynamic {
    fn initial(&self) -> Belief<N> {
        let p = &self.parameters;
        let mut mean: Column<N> = Column::zeros();
        let mut sigma: Column<N> = Column::zeros();
        for i in 0..3 {
            mean[i] = p.start.position[i];
            mean[U + i] = p.start.velocity[i];
            sigma[i] = p.start.position_sigma[i];
            sigma[U + i] = p.start.velocity_sigma;
            sigma[D + i] = self.disturbances.force_sigma;
        }
        mean[PSI] = attitude::wrap(p.start.attitude[2]);
        sigma[PSI] = p.start.heading_sigma;
        sigma[R] = 0.1;
        sigma[D + 3] = self.disturbances.moment_sigma;
        for i in 0..2 {
            sigma[C + i] = self.disturbances.current_sigma;
        }
        sigma[B_G] = p.sensors.gyro.turn_on_sigma;
        for (state, value) in self.sensor_sigmas.into_iter().filter(|(_, s)| *s > 0.0) {
            sigma[state] = value;
        }
        Belief::new(self.order, mean, &sigma, [1.0, 0.0, 0.0, 0.0])
    }

    fn predict(&self, belief: &mut Belief<N>, interval: &Interval, witness: &mut impl Witness<N>) {
        let drive = self.drive(interval);
        let decay = libm::exp(-interval.dt / self.disturbances.correlation_time);
        let mut f = Transition::identity();
        let change = self.step(&belief.mean, &drive, [interval.dt, decay], &mut f);
        for i in 0..MOVING {
            belief.mean[i] += change[i];
        }
        (0..4).for_each(|axis| belief.mean[D + axis] *= decay);
        belief.mean[PSI] = attitude::wrap(belief.mean[PSI]);
        self.add_half_noise(belief, &drive, interval.dt);
        belief.propagate(&f);
        self.add_half_noise(belief, &drive, interval.dt);
        witness.predicted(&f);
        witness.driven(interval);
    }

    fn aid(
        &self,
        belief: &mut Belief<N>,
        _: &Interval,
        interval: &Interval,
        witness: &mut impl Witness<N>,
    ) {
        let observation = match (&interval.inertial, &interval.turning) {
            (Some(imu), _) => self.gyro(belief, interval, imu.rate[2]),
            (None, Some(turning)) => self.turn(belief, turning.end[2]),
            (None, None) => return,
        };
        if let Some(thrusts) = &interval.thrust {
            let half = 0.5 * interval.dt / self.mass[3];
            let effect = |i: usize| half * self.thrusters[i][3] * thrusts.mean[i];
            witness.direct(core::array::from_fn(effect));
        }
        let correction = fuse(belief, &observation, GYRO_GATE, witness);
        self.correct(belief, &correction);
    }

    fn motion(&self, belief: &Belief<N>, interval: &Interval) -> Motion {
        let x = &belief.mean;
        let drive = self.drive(interval);
        let now = Afloat::new(movers(x), &drive.tilt);
        let rates = self.rates(&now, &drive);
        Motion {
            position: x.fixed_rows::<3>(0).into_owned(),
            rotation: now.rotation,
            velocity: x.fixed_rows::<3>(U).into_owned(),
            rate: Vector3::new(0.0, 0.0, x[R]),
            acceleration: Vector3::new(rates[U], rates[U + 1], rates[U + 2]),
        }
    }

    fn kinematics(&self, belief: &Belief<N>, interval: &Interval) -> Kinematics<N> {
        let x = &belief.mean;
        let now = self.sensors.dvl_delay.map(|_| {
            let drive = self.drive(interval);
            (Afloat::new(movers(x), &drive.tilt), drive)
        });
        let rotation = match &now {
            Some((now, _)) => now.rotation,
            None => turned(&tilt(interval), x[PSI]),
        };
        let motion = Motion {
            position: x.fixed_rows::<3>(0).into_owned(),
            rotation,
            velocity: x.fixed_rows::<3>(U).into_owned(),
            rate: Vector3::new(0.0, 0.0, x[R]),
            acceleration: now.as_ref().map_or_else(Vector3::zeros, |(now, drive)| {
                Vector3::from_column_slice(&self.rates(now, drive)[U..U + 3])
            }),
        };
        let down = rotation.row(2).transpose();
        let turn = Block::new(PSI, first_column(down));
        let mut k = Kinematics::new(&motion, turn, self.sensors, x);
        k.position.set_block(0, &Matrix3::identity());
        k.velocity.set_block(U, &Matrix3::identity());
        k.rate.set_block(R, &first_column(Vector3::z()));
        if let Some((now, drive)) = &now {
            let j = self.jacobian(now, drive);
            for state in (PSI..MOVERS).step_by(3) {
                let by = Matrix3::from_fn(|i, k| j[U + i][state + k]);
                k.acceleration.set_block(state, &by);
            }
        }
        k
    }

    fn align(&self, belief: &mut Belief<N>, euler: [f64; 3]) {
        belief.mean[PSI] = attitude::wrap(euler[2]);
    }

    fn velocity(&self) -> usize {
        U
    }

    fn correct(&self, belief: &mut Belief<N>, correction: &Column<N>) {
        belief.mean += correction;
        belief.mean[PSI] = attitude::wrap(belief.mean[PSI]);
        if let Some(state) = self.sensors.heading_bias {
            belief.mean[state] = attitude::wrap(belief.mean[state]);
        }
    }

    fn current(&self) -> Option<[usize; 2]> {
        Some([C, C + 1])
    }

    fn thrust_effect(&self, i: usize) -> Column<N> {
        let mut effect = Column::zeros();
        for axis in 0..4 {
            effect[U + axis] = self.thrusters[i][axis] / self.mass[axis];
        }
        effect
    }

    fn uses_thrust(&self) -> bool {
        true
    }

    fn tilt_is_input(&self) -> bool {
        true
    }
}
