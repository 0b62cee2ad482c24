//! Inertial navigation in three dimensions, as an error-state filter.
//!
//! ```text
//! w = omega - b_g,  R_m = R Exp(w dt/2),  a = R_m (f - b_a) + g e_z
//! p += v dt + a dt^2/2,  v += a dt,  R = R Exp(w dt)
//! ```
//! States: position (NED), velocity over ground (NED), attitude error (body), biases of the
//! accelerometers and gyros; those of the model aid; those of the sensors. Solà (2017) ch. 5, with
//! the error on the right. Without an inertial unit the velocity turns with the attitude and
//! wanders as the parameters say a vehicle manoeuvres.

use nalgebra::{Matrix3, Vector3};

use super::Process;
use super::model_aid::{AidStates, ModelAid};
use super::rotation::{exp, matrix, right_jacobian, turned};
use crate::ParameterError;
use crate::attitude;
use crate::estimation::belief::{Belief, Column};
use crate::estimation::interval::{Inertial, Interval};
use crate::estimation::kalman::Witness;
use crate::estimation::kinematics::{Kinematics, Linearized, Motion, SensorStates, skew};
use crate::estimation::parameters::NavigationParameters;
use crate::estimation::transition::Transition;

pub(super) const P: usize = 0;
pub(super) const V: usize = 3;
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

impl InertialProcess {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &NavigationParameters, aid: Option<ModelAid>) -> Result<Self, ParameterError> {
        p.check()?;
        let base = aid.as_ref().map_or(BASE, |_| BASE + AidStates::COUNT);
        let (sensors, sensor_sigmas, order) = p.sensors.states(base);
        Ok(Self { parameters: *p, sensors, sensor_sigmas, order, aid })
    }

    /// The inertial means, or what stands for them while there are none: the rate that the
    /// attitudes speak for and a velocity that is constant along body axes.
    fn inertial<const N: usize>(&self, belief: &Belief<N>, interval: &Interval) -> (Inertial, bool) {
        if let Some(imu) = interval.inertial {
            return (imu, true);
        }
        let rate = Vector3::from(interval.attitude_rate.unwrap_or([0.0; 3]));
        let r = matrix(belief.attitude);
        let velocity = r.transpose() * belief.mean.fixed_rows::<3>(V);
        let down = r.transpose() * Vector3::z();
        let force = rate.cross(&velocity) - down * self.parameters.gravity;
        let bias = |state: usize| belief.mean.fixed_rows::<3>(state).into_owned();
        let biased = rate + bias(B_G);
        let imu = Inertial {
            specific_force: (force + bias(B_A)).into(),
            rate: biased.into(),
            rate_end: biased.into(),
        };
        (imu, false)
    }

    fn transition<const N: usize>(
        &self,
        belief: &Belief<N>,
        s: &Strapdown,
        dt: f64,
        measured: bool,
    ) -> Transition<N> {
        let r = matrix(belief.attitude);
        let r_mid = r * s.half_turn;
        let by_attitude = -r * skew(&(s.half_turn * s.force));
        let by_force = -r_mid;
        let by_rate = r_mid * skew(&s.force) * s.half_jacobian * (0.5 * dt);
        let turn = s.half_turn * s.half_turn;
        let attitude_by_rate = -right_jacobian(&(s.rate * dt)) * dt;
        let mut f = Transition::identity();
        let noise = if measured { self.aid.as_ref().map(|_| AidStates::at(BASE)) } else { None };
        let biases = if measured { 1.0 } else { 0.0 };
        for (block, factor, is_velocity) in [(P, 0.5 * dt * dt, false), (V, dt, true)] {
            for i in 0..3 {
                let velocity = if is_velocity { (V + i, 1.0) } else { (V + i, dt) };
                let own = if is_velocity { (V + i, 0.0) } else { (P + i, 1.0) };
                let part = |m: &Matrix3<f64>, state: usize, scale: f64| {
                    [0, 1, 2].map(|j| (state + j, m[(i, j)] * scale))
                };
                let rest = [
                    part(&by_attitude, THETA, factor),
                    part(&by_force, B_A, factor * biases),
                    part(&by_rate, B_G, factor * biases),
                    noise.map_or([(0, 0.0); 3], |n| part(&by_force, n.force_noise, factor)),
                ];
                let rate_noise = noise.map_or((0, 0.0), |n| (n.rate_noise, by_rate[(i, 2)] * factor));
                let row = [own, velocity, rate_noise].into_iter();
                f.set_row(block + i, row.chain(rest.into_iter().flatten()));
            }
        }
        for i in 0..3 {
            let turned = [0, 1, 2].map(|j| (THETA + j, turn[(j, i)]));
            let biased = [0, 1, 2].map(|j| (B_G + j, attitude_by_rate[(i, j)] * biases));
            let rate_noise = noise.map_or((0, 0.0), |n| (n.rate_noise, attitude_by_rate[(i, 2)]));
            f.set_row(
                THETA + i,
                turned.into_iter().chain(biased).chain(core::iter::once(rate_noise)),
            );
        }
        if let Some(aid) = &self.aid {
            aid.decay(&mut f, AidStates::at(BASE), dt);
        }
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
        for i in 0..3 {
            let q = acceleration * dt;
            belief.add_noise(V + i, q);
            belief.add_noise(P + i, q * dt * dt / 3.0);
            let cross = 0.5 * q * dt;
            belief.covariance[(P + i, V + i)] += cross;
            belief.covariance[(V + i, P + i)] += cross;
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
        let velocity = matrix(attitude) * Vector3::from(p.start.velocity);
        mean.fixed_rows_mut::<3>(P).copy_from_slice(&p.start.position);
        mean.fixed_rows_mut::<3>(V).copy_from(&velocity);
        let mut sigma: Column<N> = Column::zeros();
        let bias = |b: &crate::sensors::BiasNoise| b.turn_on_sigma;
        for i in 0..3 {
            sigma[P + i] = p.start.position_sigma[i];
            sigma[V + i] = p.start.velocity_sigma;
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
        let (imu, measured) = self.inertial(belief, interval);
        let dt = interval.dt;
        if let Some(aid) = &self.aid {
            aid.renew_noise(belief, AidStates::at(BASE), dt, &self.parameters, witness);
        }
        let s = Strapdown::new(belief, &imu, dt);
        let f = self.transition(belief, &s, dt, measured);
        let acceleration = matrix(belief.attitude) * (s.half_turn * s.force)
            + Vector3::z() * self.parameters.gravity;
        let velocity: Vector3<f64> = belief.mean.fixed_rows::<3>(V).into_owned();
        let mut p = belief.mean.fixed_rows_mut::<3>(P);
        p += velocity * dt + acceleration * (0.5 * dt * dt);
        let mut v = belief.mean.fixed_rows_mut::<3>(V);
        v += acceleration * dt;
        belief.attitude = turned(belief.attitude, &(s.rate * dt));
        if let Some(aid) = &self.aid {
            aid.decay_mean(&mut belief.mean, AidStates::at(BASE), dt);
        }
        belief.propagate(&f);
        self.add_noise(belief, dt, measured);
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
        let (imu, _) = self.inertial(belief, interval);
        let velocity = inverse * block(V);
        let rate = Vector3::from(imu.rate_end) - block(B_G);
        let force = Vector3::from(imu.specific_force) - block(B_A);
        let gravity = inverse * Vector3::z() * self.parameters.gravity;
        let acceleration = force + gravity - rate.cross(&velocity);
        Motion { position: block(P), rotation, velocity, rate, acceleration }
    }

    fn kinematics(&self, belief: &Belief<N>, interval: &Interval) -> Kinematics<N> {
        let motion = <Self as Process<N>>::motion(self, belief, interval);
        let mut position = Linearized::constant(motion.position);
        position.set_block(P, &Matrix3::identity());
        let mut velocity = Linearized::constant(motion.velocity);
        velocity.set_block(V, &motion.rotation.transpose());
        velocity.set_block(THETA, &skew(&motion.velocity));
        let mut rate = Linearized::constant(motion.rate);
        let square = |x: f64| x * x;
        let rate_variance = if interval.inertial.is_some() {
            rate.set_block(B_G, &-Matrix3::identity());
            square(self.parameters.sensors.gyro.noise_density) * GYRO_SAMPLES_HZ
        } else {
            square(self.parameters.maneuver_rate)
        };
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
            acceleration: motion.acceleration,
            sensors: self.sensors,
            mean: belief.mean,
        }
    }

    fn align(&self, belief: &mut Belief<N>, euler: [f64; 3]) {
        belief.attitude = attitude::from_euler(euler);
    }

    fn velocity(&self) -> usize {
        V
    }

    fn correct(&self, belief: &mut Belief<N>, correction: &Column<N>) {
        let turn: Vector3<f64> = correction.fixed_rows::<3>(THETA).into_owned();
        belief.mean += correction;
        belief.mean.fixed_rows_mut::<3>(THETA).fill(0.0);
        belief.attitude = turned(belief.attitude, &turn);
        if let Some(state) = self.sensors.heading_bias {
            belief.mean[state] = attitude::wrap(belief.mean[state]);
        }
    }

    fn current(&self) -> Option<[usize; 2]> {
        let states = AidStates::at(BASE);
        self.aid.as_ref().map(|_| [states.current, states.current + 1])
    }

    fn uses_thrust(&self) -> bool {
        self.aid.is_some()
    }
}

/// Bandwidth of a single gyro sample (Hz): half of common sample rates or more.
const GYRO_SAMPLES_HZ: f64 = 50.0;
