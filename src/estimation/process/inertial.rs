//! Inertial navigation in three dimensions, as an error-state filter.
//!
//! ```text
//! w = omega - b_g,  T = Exp(w dt),  R+ = R T
//! alpha = Exp(w dt/2) (f - b_a) + g R^T e_z
//! p+ = p + R (u dt + alpha dt^2/2),  u+ = T^T (u + alpha dt)
//! ```
//! States: position (NED), velocity over ground u along body axes, attitude error (body), biases of
//! the accelerometers and gyros; those of the model aid; those of the sensors. Solà (2017) ch. 5, with
//! the error on the right. The velocity log then measures states alone: a heading that is not
//! observable stays so, where a velocity in NED would let every correction of it leak into the
//! heading (the inconsistency that invariant filters cure, Barrau & Bonnabel 2017). Without an
//! inertial unit the velocity stays constant along the body and wanders as the parameters say.

use nalgebra::{Matrix3, Vector3};

use super::Process;
use super::model_aid::{AidStates, ModelAid};
use super::rotation::{exp, matrix, right_jacobian, turn_attitude, turned};
use crate::ParameterError;
use crate::attitude;
use crate::estimation::belief::{Belief, Column};
use crate::estimation::interval::{Inertial, Interval};
use crate::estimation::kalman::Witness;
use crate::estimation::kinematics::{Kinematics, Linearized, Motion, SensorStates, skew};
use crate::estimation::parameters::NavigationParameters;
use crate::estimation::transition::Transition;

pub(super) const P: usize = 0;
pub(super) const U: usize = 3;
pub(super) const THETA: usize = 6;
pub(super) const B_A: usize = 9;
pub(super) const B_G: usize = 12;
const BASE: usize = 15;

/// Inertial navigation; with a model aid if there is one.
#[derive(Clone, Debug)]
pub struct InertialProcess {
    parameters: NavigationParameters,
    sensors: SensorStates,
    sensor_sigmas: [(usize, f64); 4],
    order: usize,
    aid: Option<ModelAid>,
}

/// The quantities of a prediction that its derivatives need too.
pub(super) struct Strapdown {
    /// Rate and specific force less their biases.
    pub(super) rate: Vector3<f64>,
    pub(super) force: Vector3<f64>,
    /// Exp(w dt/2).
    pub(super) half_turn: Matrix3<f64>,
    /// Right Jacobian at w dt/2.
    pub(super) half_jacobian: Matrix3<f64>,
}

impl Strapdown {
    pub(super) fn new<const N: usize>(belief: &Belief<N>, imu: &Inertial, dt: f64) -> Self {
        let rate = Vector3::from(imu.rate) - belief.mean.fixed_rows::<3>(B_G);
        let force = Vector3::from(imu.specific_force) - belief.mean.fixed_rows::<3>(B_A);
        let half = rate * (0.5 * dt);
        Self { rate, force, half_turn: exp(&half), half_jacobian: right_jacobian(&half) }
    }
}

/// Row i of a block of derivatives by three states.
fn part(m: &Matrix3<f64>, i: usize, state: usize) -> [(usize, f64); 3] {
    [0, 1, 2].map(|j| (state + j, m[(i, j)]))
}

/// Row i of some blocks; the noise of an interval acts where a bias does.
fn row(
    blocks: &[(usize, Matrix3<f64>)],
    i: usize,
    noise: Option<AidStates>,
) -> impl Iterator<Item = (usize, f64)> {
    blocks.iter().flat_map(move |(state, m)| {
        let [a, b, c] = part(m, i, *state);
        let by_noise = match (noise, *state) {
            (Some(at), B_A) => part(m, i, at.force_noise),
            (Some(at), B_G) => [(at.rate_noise, m[(i, 2)]), (0, 0.0), (0, 0.0)],
            _ => [(0, 0.0); 3],
        };
        [a, b, c].into_iter().chain(by_noise)
    })
}

impl InertialProcess {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &NavigationParameters, aid: Option<ModelAid>) -> Result<Self, ParameterError> {
        p.check()?;
        let base = aid.as_ref().map_or(BASE, |_| BASE + AidStates::COUNT);
        let (sensors, sensor_sigmas, order) = p.sensors.states(base);
        Ok(Self { parameters: *p, sensors, sensor_sigmas, order, aid })
    }

    /// The rate that the attitudes speak for while there are no gyros (rad/s).
    fn attitude_rate(interval: &Interval) -> Vector3<f64> {
        Vector3::from(interval.attitude_rate.unwrap_or([0.0; 3]))
    }

    /// A prediction without inertial means: `p+ = p + R (I + T) u dt/2` with `T = Exp(omega dt)`.
    fn coast<const N: usize>(&self, belief: &mut Belief<N>, interval: &Interval) -> Transition<N> {
        let dt = interval.dt;
        let turn = Self::attitude_rate(interval) * dt;
        let (r, t) = (matrix(belief.attitude), exp(&turn));
        let u: Vector3<f64> = belief.mean.fixed_rows::<3>(U).into_owned();
        let by_velocity = r * (Matrix3::identity() + t) * (0.5 * dt);
        let by_attitude = -r * skew(&((u + t * u) * (0.5 * dt)));
        let mut f = Transition::identity();
        for i in 0..3 {
            let own = core::iter::once((P + i, 1.0));
            f.set_row(
                P + i,
                own.chain(part(&by_velocity, i, U)).chain(part(&by_attitude, i, THETA)),
            );
        }
        (0..3).for_each(|i| f.set_row(THETA + i, part(&t.transpose(), i, THETA)));
        let mut p = belief.mean.fixed_rows_mut::<3>(P);
        p += by_velocity * u;
        belief.attitude = turned(belief.attitude, &turn);
        f
    }

    /// A prediction with inertial means.
    fn navigate<const N: usize>(
        &self,
        belief: &mut Belief<N>,
        imu: &Inertial,
        dt: f64,
    ) -> Transition<N> {
        let s = Strapdown::new(belief, imu, dt);
        let r = matrix(belief.attitude);
        let back = (s.half_turn * s.half_turn).transpose();
        let down = r.transpose() * Vector3::z();
        let u: Vector3<f64> = belief.mean.fixed_rows::<3>(U).into_owned();
        let force = s.half_turn * s.force;
        let alpha = force + down * self.parameters.gravity;
        let displacement = u * dt + alpha * (0.5 * dt * dt);
        let next = back * (u + alpha * dt);

        let jacobian = right_jacobian(&(s.rate * dt)) * dt;
        let force_by_rate = s.half_turn * skew(&s.force) * s.half_jacobian * (0.5 * dt);
        let along = u * dt + force * (0.5 * dt * dt);
        let position = [
            (THETA, -r * skew(&along)),
            (B_A, -r * s.half_turn * (0.5 * dt * dt)),
            (B_G, r * force_by_rate * (0.5 * dt * dt)),
        ];
        let velocity = [
            (THETA, back * skew(&down) * (self.parameters.gravity * dt)),
            (B_A, -back * s.half_turn * dt),
            (B_G, back * force_by_rate * dt - skew(&next) * jacobian),
        ];
        let attitude = [(THETA, back), (B_G, -jacobian)];

        let mut f = Transition::identity();
        let noise = self.aid.as_ref().map(|_| AidStates::at(BASE));
        for i in 0..3 {
            let own = [(P + i, 1.0)].into_iter().chain(part(&(r * dt), i, U));
            f.set_row(P + i, own.chain(row(&position, i, noise)));
        }
        for i in 0..3 {
            f.set_row(U + i, part(&back, i, U).into_iter().chain(row(&velocity, i, noise)));
        }
        (0..3).for_each(|i| f.set_row(THETA + i, row(&attitude, i, noise)));

        let mut p = belief.mean.fixed_rows_mut::<3>(P);
        p += r * displacement;
        belief.mean.fixed_rows_mut::<3>(U).copy_from(&next);
        belief.attitude = turned(belief.attitude, &(s.rate * dt));
        f
    }

    fn add_noise<const N: usize>(&self, belief: &mut Belief<N>, dt: f64, measured: bool) {
        let p = &self.parameters;
        let (force, rate) = match measured {
            true => (p.sensors.accelerometer.noise_density, p.sensors.gyro.noise_density),
            false => (p.maneuver_acceleration, p.maneuver_rate),
        };
        // With a model aid the noise of an interval is a state, and comes in through F; that of the
        // rates across does not.
        let modelled = self.aid.is_some() && measured;
        let acceleration = if modelled { 0.0 } else { force * force };
        let q = acceleration * dt;
        let r = matrix(belief.attitude);
        for i in 0..3 {
            belief.add_noise(U + i, q);
            belief.add_noise(P + i, q * dt * dt / 3.0);
            for j in 0..3 {
                let cross = r[(i, j)] * (0.5 * q * dt);
                belief.covariance[(P + i, U + j)] += cross;
                belief.covariance[(U + j, P + i)] += cross;
            }
            if !(modelled && i == 2) {
                belief.add_noise(THETA + i, rate * rate * dt);
            }
            let walk = |density: f64| density * density * dt;
            belief.add_noise(B_A + i, walk(p.sensors.accelerometer.random_walk));
            belief.add_noise(B_G + i, walk(p.sensors.gyro.random_walk));
        }
        if let Some(aid) = &self.aid {
            aid.add_noise(belief, AidStates::at(BASE), dt);
        }
    }
}

impl<const N: usize> Process<N> for InertialProcess {
    fn initial(&self) -> Belief<N> {
        let p = &self.parameters;
        let attitude = attitude::from_euler(p.start.attitude);
        let mut mean: Column<N> = Column::zeros();
        mean.fixed_rows_mut::<3>(P).copy_from_slice(&p.start.position);
        mean.fixed_rows_mut::<3>(U).copy_from_slice(&p.start.velocity);
        let mut sigma: Column<N> = Column::zeros();
        let bias = |b: &crate::sensors::BiasNoise| b.turn_on_sigma;
        for i in 0..3 {
            sigma[P + i] = p.start.position_sigma[i];
            sigma[U + i] = p.start.velocity_sigma;
            sigma[THETA + i] = if i < 2 { p.start.tilt_sigma } else { p.start.heading_sigma };
            sigma[B_A + i] = bias(&p.sensors.accelerometer);
            sigma[B_G + i] = bias(&p.sensors.gyro);
        }
        if let Some(aid) = &self.aid {
            aid.start(&mut sigma, AidStates::at(BASE));
        }
        for (state, value) in self.sensor_sigmas.into_iter().filter(|(_, s)| *s > 0.0) {
            sigma[state] = value;
        }
        Belief::new(self.order, mean, &sigma, attitude)
    }

    fn predict(&self, belief: &mut Belief<N>, interval: &Interval, witness: &mut impl Witness<N>) {
        let dt = interval.dt;
        if let Some(aid) = &self.aid {
            aid.renew_noise(belief, AidStates::at(BASE), dt, &self.parameters, witness);
        }
        let mut f = match &interval.inertial {
            Some(imu) => self.navigate(belief, imu, dt),
            None => self.coast(belief, interval),
        };
        if let Some(aid) = &self.aid {
            aid.decay(&mut f, AidStates::at(BASE), dt);
            aid.decay_mean(&mut belief.mean, AidStates::at(BASE), dt);
        }
        belief.propagate(&f);
        self.add_noise(belief, dt, interval.inertial.is_some());
        witness.predicted(&f);
    }

    fn aid(
        &self,
        belief: &mut Belief<N>,
        before: &Interval,
        interval: &Interval,
        witness: &mut impl Witness<N>,
    ) {
        if let Some(aid) = &self.aid {
            let correct = |b: &mut Belief<N>, c: &Column<N>| self.correct(b, c);
            aid.balance(belief, AidStates::at(BASE), before, interval, correct, witness);
        }
    }

    fn motion(&self, belief: &Belief<N>, interval: &Interval) -> Motion {
        let block = |state: usize| belief.mean.fixed_rows::<3>(state).into_owned();
        let rotation = matrix(belief.attitude);
        let inverse = rotation.transpose();
        let velocity = block(U);
        let (rate, acceleration) = match &interval.inertial {
            Some(imu) => {
                let rate = Vector3::from(imu.rate_end) - block(B_G);
                let force = Vector3::from(imu.specific_force) - block(B_A);
                let gravity = inverse * Vector3::z() * self.parameters.gravity;
                (rate, force + gravity - rate.cross(&velocity))
            }
            None => (Self::attitude_rate(interval), Vector3::zeros()),
        };
        Motion { position: block(P), rotation, velocity, rate, acceleration }
    }

    fn kinematics(&self, belief: &Belief<N>, interval: &Interval) -> Kinematics<N> {
        let motion = <Self as Process<N>>::motion(self, belief, interval);
        let mut position = Linearized::constant(motion.position);
        position.set_block(P, &Matrix3::identity());
        let mut velocity = Linearized::constant(motion.velocity);
        velocity.set_block(U, &Matrix3::identity());
        let mut rate = Linearized::constant(motion.rate);
        let square = |x: f64| x * x;
        let rate_variance = if interval.inertial.is_some() {
            rate.set_block(B_G, &-Matrix3::identity());
            square(self.parameters.sensors.gyro.noise_density) * GYRO_SAMPLES_HZ
        } else {
            square(self.parameters.maneuver_rate)
        };
        let mut acceleration = Linearized::constant(motion.acceleration);
        if interval.inertial.is_some() {
            let gravity = motion.rotation.transpose() * Vector3::z() * self.parameters.gravity;
            acceleration.set_block(U, &-skew(&motion.rate));
            acceleration.set_block(THETA, &skew(&gravity));
            acceleration.set_block(B_A, &-Matrix3::identity());
            acceleration.set_block(B_G, &-skew(&motion.velocity));
        }
        let mut rotation_rows = [Column::zeros(); 3];
        for (i, row) in rotation_rows.iter_mut().enumerate() {
            row[THETA + i] = 1.0;
        }
        Kinematics {
            position,
            rotation: motion.rotation,
            tilt_is_input: false,
            rotation_rows,
            velocity,
            rate,
            rate_variance,
            acceleration,
            sensors: self.sensors,
            mean: belief.mean,
        }
    }

    fn align(&self, belief: &mut Belief<N>, euler: [f64; 3]) {
        belief.attitude = attitude::from_euler(euler);
    }

    fn velocity(&self) -> usize {
        U
    }

    fn correct(&self, belief: &mut Belief<N>, correction: &Column<N>) {
        belief.mean += correction;
        turn_attitude(belief, THETA);
        if let Some(state) = self.sensors.heading_bias {
            belief.mean[state] = attitude::wrap(belief.mean[state]);
        }
    }

    fn current(&self) -> Option<[usize; 2]> {
        let states = AidStates::at(BASE);
        self.aid.as_ref().map(|_| [states.current, states.current + 1])
    }

    fn coasts(&self, interval: &Interval) -> bool {
        interval.inertial.is_none()
    }

    fn uses_thrust(&self) -> bool {
        self.aid.is_some()
    }
}

/// Bandwidth of a single gyro sample (Hz): half of common sample rates or more.
const GYRO_SAMPLES_HZ: f64 = 50.0;
