//! Inertial navigation in three dimensions, as an error-state filter.
//!
//! ```text
//! w = omega - b_g,  T = Exp(w dt),  R+ = R T
//! alpha = Exp(w dt/2) (f - b_a) + g R^T e_z
//! p+ = p + R (u dt + alpha dt^2/2),  u+ = T^T (u + alpha dt)
//! ```
//! States: position (NED), velocity over ground u along body axes, attitude error (body), biases of
//! the accelerometers and gyros; those of the model aid; those of the sensors. Solà (2017) ch. 5,
//! with the error on the right. The velocity log then measures states directly: an unobservable
//! heading stays unobservable, whereas with a velocity in NED every correction of it would leak
//! into the heading (the inconsistency that invariant filters avoid, Barrau & Bonnabel 2017).
//! Without an inertial unit the body velocity is constant except for a random walk set by the
//! parameters.

use nalgebra::{Matrix3, Vector3};

use super::Process;
use super::model_aid::{AidStates, ModelAid};
use super::rotation::{exp, matrix, right_jacobian, turn_attitude, turned};
use crate::ParameterError;
use crate::attitude;
use crate::estimation::belief::{Belief, Column};
use crate::estimation::interval::{Inertial, Interval};
use crate::estimation::kalman::Witness;
use crate::estimation::kinematics::{Block, Kinematics, Motion, SensorStates, skew};
use crate::estimation::parameters::NavigationParameters;
use crate::estimation::transition::Transition;

pub(super) const P: usize = 0;
pub(super) const U: usize = 3;
pub(super) const THETA: usize = 6;
pub(super) const B_A: usize = 9;
pub(super) const B_G: usize = 12;
const BASE: usize = 15;

/// Inertial navigation, optionally with a model aid.
#[derive(Clone, Debug)]
pub struct InertialProcess {
    parameters: NavigationParameters,
    sensors: SensorStates,
    sensor_sigmas: [(usize, f64); 4],
    order: usize,
    aid: Option<ModelAid>,
}

/// The quantities of a prediction that its derivatives also need.
pub(super) struct Strapdown {
    /// Rate and specific force minus their biases.
    pub(super) rate: Vector3<f64>,
    pub(super) force: Vector3<f64>,
}

impl Strapdown {
    pub(super) fn new<const N: usize>(belief: &Belief<N>, imu: &Inertial) -> Self {
        let rate = Vector3::from(imu.rate) - belief.mean.fixed_rows::<3>(B_G);
        let force = Vector3::from(imu.specific_force) - belief.mean.fixed_rows::<3>(B_A);
        Self { rate, force }
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

    /// A prediction without inertial means: `p+ = p + R (I + T) u dt/2` with `T = Exp(omega dt)`.
    fn coast<const N: usize>(
        &self,
        belief: &mut Belief<N>,
        interval: &Interval,
        f: &mut Transition<N>,
    ) {
        let dt = interval.dt;
        let turn = Vector3::from(interval.turning.unwrap_or_default().mean) * dt;
        let (r, t) = (matrix(belief.attitude), exp(&turn));
        let u: Vector3<f64> = belief.mean.fixed_rows::<3>(U).into_owned();
        let by_velocity = r * (Matrix3::identity() + t) * (0.5 * dt);
        let by_attitude = -r * skew(&((u + t * u) * (0.5 * dt)));
        f.set_rows(P, &[(P, Matrix3::identity()), (U, by_velocity), (THETA, by_attitude)]);
        f.set_rows(THETA, &[(THETA, t.transpose())]);
        let mut p = belief.mean.fixed_rows_mut::<3>(P);
        p += by_velocity * u;
        belief.attitude = turned(belief.attitude, &turn);
    }

    /// A prediction with inertial means; like the other one it sets F, which is the identity
    /// before.
    fn navigate<const N: usize>(
        &self,
        belief: &mut Belief<N>,
        imu: &Inertial,
        dt: f64,
        f: &mut Transition<N>,
    ) {
        let s = Strapdown::new(belief, imu);
        let half = s.rate * (0.5 * dt);
        let half_turn = exp(&half);
        let r = matrix(belief.attitude);
        let back = (half_turn * half_turn).transpose();
        let down = r.transpose() * Vector3::z();
        let u: Vector3<f64> = belief.mean.fixed_rows::<3>(U).into_owned();
        let force = half_turn * s.force;
        let alpha = force + down * self.parameters.gravity;
        let displacement = u * dt + alpha * (0.5 * dt * dt);
        let next = back * (u + alpha * dt);

        let jacobian = right_jacobian(&(s.rate * dt)) * dt;
        // Exp(a) [f]x Jr(a) = [Exp(a) f]x Jr(-a), and below `back half_turn = half_turn^T`.
        let force_by_rate = skew(&force) * right_jacobian(&-half) * (0.5 * dt);
        let along = u * dt + force * (0.5 * dt * dt);
        self.set_rows(
            f,
            P,
            [
                (P, Matrix3::identity()),
                (U, r * dt),
                (THETA, -r * skew(&along)),
                (B_A, -r * half_turn * (0.5 * dt * dt)),
                (B_G, r * force_by_rate * (0.5 * dt * dt)),
            ],
        );
        self.set_rows(
            f,
            U,
            [
                (U, back),
                (THETA, back * skew(&down) * (self.parameters.gravity * dt)),
                (B_A, -half_turn.transpose() * dt),
                (B_G, back * force_by_rate * dt - skew(&next) * jacobian),
            ],
        );
        self.set_rows(f, THETA, [(THETA, back), (B_G, -jacobian)]);

        let mut p = belief.mean.fixed_rows_mut::<3>(P);
        p += r * displacement;
        belief.mean.fixed_rows_mut::<3>(U).copy_from(&next);
        belief.attitude = turned(belief.attitude, &(s.rate * dt));
    }

    /// Rows of F; with a model aid the noise of an interval enters like a bias.
    fn set_rows<const N: usize, const B: usize>(
        &self,
        f: &mut Transition<N>,
        state: usize,
        blocks: [(usize, Matrix3<f64>); B],
    ) {
        let group = f.add_group(state, 3, 0);
        let noise = self.aid.as_ref().map(|_| AidStates::at(BASE));
        for (of, by) in &blocks {
            group.set(*of, by);
            match (noise, *of) {
                (Some(at), B_A) => group.set(at.force_noise, by),
                (Some(at), B_G) => group.set_column(at.rate_noise, &by.column(2).into_owned()),
                _ => {}
            }
        }
    }

    fn add_noise<const N: usize>(&self, belief: &mut Belief<N>, dt: f64, measured: bool) {
        let p = &self.parameters;
        let (force, rate) = match measured {
            true => (p.sensors.accelerometer.noise_density, p.sensors.gyro.noise_density),
            false => (p.maneuver_acceleration, p.maneuver_rate),
        };
        // With a model aid the noise of an interval is a state, and enters through F; that of the
        // roll and pitch rates does not.
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
        let mut f = Transition::identity();
        match &interval.inertial {
            Some(imu) => self.navigate(belief, imu, dt, &mut f),
            None => self.coast(belief, interval, &mut f),
        }
        let decays = self.aid.as_ref().map(|aid| (aid, aid.decays(dt)));
        if let Some((aid, decays)) = decays {
            aid.decay(&mut f, &mut belief.mean, AidStates::at(BASE), decays);
        }
        belief.propagate(&f);
        self.add_noise(belief, dt, interval.inertial.is_some());
        if let Some((aid, decays)) = decays {
            aid.add_noise(belief, AidStates::at(BASE), dt, decays);
        }
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
            None => {
                let rate = Vector3::from(interval.turning.unwrap_or_default().end);
                (rate, Vector3::zeros())
            }
        };
        Motion { position: block(P), rotation, velocity, rate, acceleration }
    }

    fn kinematics(&self, belief: &Belief<N>, interval: &Interval) -> Kinematics<N> {
        let motion = <Self as Process<N>>::motion(self, belief, interval);
        let turn = Block::new(THETA, Matrix3::identity());
        let mut k = Kinematics::new(&motion, turn, self.sensors, &belief.mean);
        k.position.set_block(P, &Matrix3::identity());
        k.velocity.set_block(U, &Matrix3::identity());
        let square = |x: f64| x * x;
        (k.rate_variance, k.tracking_variance) = match (&interval.inertial, &interval.turning) {
            (Some(_), _) => {
                k.rate.set_block(B_G, &-Matrix3::identity());
                (square(self.parameters.sensors.gyro.noise_density) * GYRO_SAMPLES_HZ, 0.0)
            }
            (None, Some(turning)) => (0.0, turning.variance),
            (None, None) => (square(self.parameters.maneuver_rate), 0.0),
        };
        if interval.inertial.is_some() && self.sensors.dvl_delay.is_some() {
            let gravity = motion.rotation.transpose() * Vector3::z() * self.parameters.gravity;
            k.acceleration.set_block(U, &-skew(&motion.rate));
            k.acceleration.set_block(THETA, &skew(&gravity));
            k.acceleration.set_block(B_A, &-Matrix3::identity());
            k.acceleration.set_block(B_G, &-skew(&motion.velocity));
        }
        k
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
