//! The equations of motion in four degrees of freedom as a process: surge, sway, heave, yaw.
//!
//! ```text
//! m1 nu1' = -(d1 + D1|nu1|) nu1 + m2 nu2 r + X + dX     x' = u ct cpsi + ... (measured roll and pitch)
//! m2 nu2' = -(d2 + D2|nu2|) nu2 - m1 nu1 r + Y + dY     psi' = r cos(roll) / cos(pitch)
//! m3 nu3' = -(d3 + D3|nu3|) nu3 + (W - B) + Z + dZ      current, gyro bias: random walks
//! m6 r' = -(d6 + D6|r|) r - (a22 - a11) nu1 nu2 + N + dN    d: Ornstein-Uhlenbeck
//! u = nu + R^T c,   u' = nu' - (r e_z) x R^T c
//! ```
//! u is the velocity over ground along body axes, nu that through the water, c the current. The gyro
//! is a measurement, compared with the yaw rate at the middle of its interval. Without thrusts u and r
//! stay as they are and wander as the parameters say. Eqs (27) to (30) of the paper with their signs
//! corrected; Fossen (2011) ch. 7.3. The step is the midpoint rule, F its exact derivative,
//! `Q_d = (F Q F^T + Q) dt/2`.

use nalgebra::{Matrix3, Vector3};

use super::Process;
use crate::ParameterError;
use crate::attitude;
use crate::estimation::belief::{Belief, Column};
use crate::estimation::interval::Interval;
use crate::estimation::kalman::{Witness, fuse};
use crate::estimation::kinematics::{Kinematics, Linearized, Motion, SensorStates};
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
/// States that rates depend on.
const MOVERS: usize = 15;

type Rates = [f64; MOVING];
type Jacobian = [[f64; MOVERS]; MOVING];

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

/// Forces of an interval, and whether they are known.
struct Forces {
    thrust: [f64; 4],
    known: bool,
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

    fn forces(&self, interval: &Interval) -> Forces {
        let Some(thrusts) = &interval.thrust else {
            return Forces { thrust: [0.0; 4], known: false };
        };
        let mut thrust = [0.0; 4];
        for (unit, force) in self.thrusters.iter().zip(thrusts.mean) {
            for axis in 0..4 {
                thrust[axis] += unit[axis] * force;
            }
        }
        Forces { thrust, known: true }
    }

    /// Time derivatives of the moving states, and theirs by the states.
    fn rates(&self, x: &[f64; MOVERS], forces: &Forces, tilt: [f64; 2]) -> (Rates, Jacobian) {
        let mut rates = [0.0; MOVING];
        let mut j = [[0.0; MOVERS]; MOVING];
        let rotation = rotation([tilt[0], tilt[1], x[PSI]]);
        let u = Vector3::new(x[U], x[U + 1], x[U + 2]);
        let velocity = rotation * u;
        let turn = libm::cos(tilt[0]) / libm::cos(tilt[1]).max(0.05);
        for i in 0..3 {
            rates[i] = velocity[i];
            (0..3).for_each(|k| j[i][U + k] = rotation[(i, k)]);
        }
        j[0][PSI] = -velocity.y;
        j[1][PSI] = velocity.x;
        rates[PSI] = x[R] * turn;
        j[PSI][R] = turn;
        if forces.known {
            self.accelerations(x, forces, &rotation.transpose(), &mut rates, &mut j);
        }
        (rates, j)
    }

    /// The rows of u and r of [`PlanarDynamic::rates`].
    fn accelerations(
        &self,
        x: &[f64; MOVERS],
        forces: &Forces,
        inverse: &Matrix3<f64>,
        rates: &mut Rates,
        j: &mut Jacobian,
    ) {
        let flow = inverse * Vector3::new(x[C], x[C + 1], 0.0);
        // The current along body axes turns against the heading.
        let by_heading = -(inverse * Vector3::z()).cross(&flow);
        let nu = Vector3::new(x[U], x[U + 1], x[U + 2]) - flow;
        let [m1, m2, _, m6] = self.mass;
        let r = x[R];
        let coupling =
            [m2 * nu.y * r, -m1 * nu.x * r, self.excess_weight, -self.munk * nu.x * nu.y];
        let speed = [nu.x, nu.y, nu.z, r];
        // By nu and r.
        let mut slope = [[0.0; 4]; 4];
        for axis in 0..4 {
            let quadratic = self.quadratic[axis] * speed[axis].abs();
            let damping = (self.linear[axis] + quadratic) * speed[axis];
            let force = coupling[axis] - damping + forces.thrust[axis] + x[D + axis];
            rates[U + axis] = force / self.mass[axis];
            slope[axis][axis] = -(self.linear[axis] + 2.0 * quadratic) / self.mass[axis];
            j[U + axis][D + axis] = 1.0 / self.mass[axis];
        }
        slope[0][1] = m2 * r / m1;
        slope[0][3] = m2 * nu.y / m1;
        slope[1][0] = -m1 * r / m2;
        slope[1][3] = -m1 * nu.x / m2;
        slope[3][0] = -self.munk * nu.y / m6;
        slope[3][1] = -self.munk * nu.x / m6;
        for axis in 0..4 {
            let row = &mut j[U + axis];
            (0..4).for_each(|k| row[U + k] = slope[axis][k]);
            for k in 0..3 {
                (0..2).for_each(|i| row[C + i] -= slope[axis][k] * inverse[(k, i)]);
                row[PSI] -= slope[axis][k] * by_heading[k];
            }
        }
        // u' = nu' - (r e_z) x (R^T c).
        rates[U] += r * flow.y;
        rates[U + 1] -= r * flow.x;
        j[U][R] += flow.y;
        j[U + 1][R] -= flow.x;
        j[U][PSI] += r * by_heading.y;
        j[U + 1][PSI] -= r * by_heading.x;
        for i in 0..2 {
            j[U][C + i] += r * inverse[(1, i)];
            j[U + 1][C + i] -= r * inverse[(0, i)];
        }
    }

    /// Midpoint step: the change of the moving states, and F.
    fn step<const N: usize>(
        &self,
        mean: &Column<N>,
        forces: &Forces,
        interval: &Interval,
    ) -> (Rates, Transition<N>) {
        let dt = interval.dt;
        let x: [f64; MOVERS] = core::array::from_fn(|i| mean[i]);
        let (first, j_first) = self.rates(&x, forces, interval.tilt);
        let mut middle = x;
        for i in 0..MOVING {
            middle[i] += 0.5 * dt * first[i];
        }
        let (rates, j_middle) = self.rates(&middle, forces, interval.tilt);
        let mut f = Transition::identity();
        for i in 0..MOVING {
            // d/dx of x + dt g(x + dt/2 g(x)).
            let mut row = j_middle[i];
            for k in 0..MOVING {
                let factor = 0.5 * dt * j_middle[i][k];
                if factor != 0.0 {
                    for (sum, value) in row.iter_mut().zip(&j_first[k]) {
                        *sum += factor * value;
                    }
                }
            }
            let own = core::iter::once((i, 1.0));
            f.set_row(i, own.chain(row.into_iter().enumerate().map(|(k, value)| (k, dt * value))));
        }
        let decay = libm::exp(-dt / self.disturbances.correlation_time);
        (0..4).for_each(|axis| f.scale(D + axis, decay));
        (rates.map(|rate| rate * dt), f)
    }

    /// Adds half of the process noise of an interval.
    fn add_half_noise<const N: usize>(&self, belief: &mut Belief<N>, forces: &Forces, dt: f64) {
        let d = &self.disturbances;
        let square = |x: f64| x * x;
        let half = 0.5 * dt;
        for axis in 0..4 {
            let yaw = axis == 3;
            let white = match (forces.known, yaw) {
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

    /// The yaw rate that successive attitudes speak for, while there is no gyro.
    fn turn<const N: usize>(&self, belief: &Belief<N>, rate: f64) -> Observation<N> {
        let mut row = Column::zeros();
        row[R] = 1.0;
        let empty = Column::zeros();
        let sigma = self.parameters.maneuver_rate;
        let innovation = [rate - belief.mean[R], 0.0, 0.0];
        Observation::new(1, innovation, [row, empty, empty], [sigma * sigma, 1.0, 1.0])
    }

    /// The gyro's mean against the yaw rate at the middle of its interval.
    #[must_use]
    pub fn gyro<const N: usize>(
        &self,
        belief: &Belief<N>,
        interval: &Interval,
        rate: f64,
    ) -> Observation<N> {
        let x: [f64; MOVERS] = core::array::from_fn(|i| belief.mean[i]);
        let (rates, j) = self.rates(&x, &self.forces(interval), interval.tilt);
        let half = 0.5 * interval.dt;
        let mut row = Column::zeros();
        for k in 0..MOVERS {
            row[k] = -half * j[R][k];
        }
        row[R] += 1.0;
        row[B_G] += 1.0;
        let predicted = x[R] - half * rates[R] + x[B_G];
        let density = self.parameters.sensors.gyro.noise_density;
        let empty = Column::zeros();
        Observation::new(
            1,
            [rate - predicted, 0.0, 0.0],
            [row, empty, empty],
            [density * density / interval.dt + GYRO_FLOOR, 1.0, 1.0],
        )
    }
}

/// Rotation matrix of roll, pitch and yaw.
fn rotation(euler: [f64; 3]) -> Matrix3<f64> {
    let r = attitude::rotation_euler(euler);
    Matrix3::from_fn(|i, j| r[i][j])
}

/// Least variance of a gyro's mean ((rad/s)^2).
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
        let forces = self.forces(interval);
        let (change, f) = self.step(&belief.mean, &forces, interval);
        for i in 0..MOVING {
            belief.mean[i] += change[i];
        }
        let decay = libm::exp(-interval.dt / self.disturbances.correlation_time);
        (0..4).for_each(|axis| belief.mean[D + axis] *= decay);
        belief.mean[PSI] = attitude::wrap(belief.mean[PSI]);
        self.add_half_noise(belief, &forces, interval.dt);
        belief.propagate(&f);
        self.add_half_noise(belief, &forces, interval.dt);
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
        let observation = match (&interval.inertial, interval.attitude_rate) {
            (Some(imu), _) => self.gyro(belief, interval, imu.rate[2]),
            (None, Some(rate)) => self.turn(belief, rate[2]),
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
        let movers: [f64; MOVERS] = core::array::from_fn(|i| x[i]);
        let (rates, _) = self.rates(&movers, &self.forces(interval), interval.tilt);
        Motion {
            position: x.fixed_rows::<3>(0).into_owned(),
            rotation: rotation([interval.tilt[0], interval.tilt[1], x[PSI]]),
            velocity: x.fixed_rows::<3>(U).into_owned(),
            rate: Vector3::new(0.0, 0.0, x[R]),
            acceleration: Vector3::new(rates[U], rates[U + 1], rates[U + 2]),
        }
    }

    fn kinematics(&self, belief: &Belief<N>, interval: &Interval) -> Kinematics<N> {
        let motion = <Self as Process<N>>::motion(self, belief, interval);
        let inverse = motion.rotation.transpose();
        let mut position = Linearized::constant(motion.position);
        position.set_block(0, &Matrix3::identity());
        let mut velocity = Linearized::constant(motion.velocity);
        velocity.set_block(U, &Matrix3::identity());
        let mut acceleration = Linearized::<N>::constant(motion.acceleration);
        if self.sensors.dvl_delay.is_some() {
            let movers: [f64; MOVERS] = core::array::from_fn(|i| belief.mean[i]);
            let (_, j) = self.rates(&movers, &self.forces(interval), interval.tilt);
            for (i, row) in acceleration.rows.iter_mut().enumerate() {
                row.as_mut_slice()[..MOVERS].copy_from_slice(&j[U + i]);
            }
        }
        let mut rotation_rows = [Column::zeros(); 3];
        (0..3).for_each(|i| rotation_rows[i][PSI] = inverse[(i, 2)]);
        let mut rate = Linearized::constant(motion.rate);
        rate.rows[2][R] = 1.0;
        Kinematics {
            position,
            rotation: motion.rotation,
            tilt_is_input: true,
            rotation_rows,
            velocity,
            rate,
            rate_variance: 0.0,
            acceleration,
            sensors: self.sensors,
            mean: belief.mean,
        }
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
}
