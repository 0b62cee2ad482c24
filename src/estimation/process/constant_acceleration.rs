//! Constant acceleration, as in robot_localization with its default process noise.
//!
//! Position, attitude, velocity, angular rate and acceleration along body axes, the last two
//! constant except for noise; gyros and accelerometers are measurements of them. The baseline for
//! users who tune nothing: no vehicle model, no biases. Moore & Stouch (2014).

use nalgebra::{Matrix3, Vector3};

use super::Process;
use super::rotation::{exp, matrix, right_jacobian, turn_attitude, turned};
use crate::ParameterError;
use crate::attitude;
use crate::estimation::belief::{Belief, Column};
use crate::estimation::interval::Interval;
use crate::estimation::kalman::{Witness, fuse};
use crate::estimation::kinematics::{Block, Kinematics, Linearized, Motion, SensorStates, skew};
use crate::estimation::parameters::NavigationParameters;
use crate::estimation::sensor::Observation;
use crate::estimation::transition::Transition;

const P: usize = 0;
const THETA: usize = 3;
const V: usize = 6;
const OMEGA: usize = 9;
const A: usize = 12;
const BASE: usize = 15;

/// Default process noise of robot_localization: variance per second of position, attitude, velocity,
/// angular rate and acceleration.
const NOISE: [f64; BASE] =
    [0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04, 0.01, 0.01, 0.02, 0.01, 0.01, 0.015];

/// The constant-acceleration process.
#[derive(Clone, Debug)]
pub struct ConstantAcceleration {
    parameters: NavigationParameters,
    sensors: SensorStates,
    sensor_sigmas: [(usize, f64); 4],
    order: usize,
}

impl ConstantAcceleration {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &NavigationParameters) -> Result<Self, ParameterError> {
        p.check()?;
        let (sensors, sensor_sigmas, order) = p.sensors.states(BASE);
        Ok(Self { parameters: *p, sensors, sensor_sigmas, order })
    }
}

fn block<const N: usize>(belief: &Belief<N>, state: usize) -> Vector3<f64> {
    belief.mean.fixed_rows::<3>(state).into_owned()
}

impl<const N: usize> Process<N> for ConstantAcceleration {
    fn initial(&self) -> Belief<N> {
        let p = &self.parameters;
        let mut mean: Column<N> = Column::zeros();
        mean.fixed_rows_mut::<3>(P).copy_from_slice(&p.start.position);
        mean.fixed_rows_mut::<3>(V).copy_from_slice(&p.start.velocity);
        let mut sigma: Column<N> = Column::zeros();
        for i in 0..3 {
            sigma[P + i] = p.start.position_sigma[i];
            sigma[THETA + i] = if i < 2 { p.start.tilt_sigma } else { p.start.heading_sigma };
            sigma[V + i] = p.start.velocity_sigma;
            sigma[OMEGA + i] = 0.1;
            sigma[A + i] = 0.1;
        }
        for (state, value) in self.sensor_sigmas.into_iter().filter(|(_, s)| *s > 0.0) {
            sigma[state] = value;
        }
        Belief::new(self.order, mean, &sigma, attitude::from_euler(p.start.attitude))
    }

    fn predict(&self, belief: &mut Belief<N>, interval: &Interval, witness: &mut impl Witness<N>) {
        let dt = interval.dt;
        let r = matrix(belief.attitude);
        let (velocity, omega, acceleration) =
            (block(belief, V), block(belief, OMEGA), block(belief, A));
        let displacement = velocity * dt + acceleration * (0.5 * dt * dt);
        let by_attitude = -r * skew(&displacement);
        let turn = omega * dt;
        let (back, by_rate) = (exp(&turn).transpose(), right_jacobian(&turn) * dt);
        let mut f = Transition::identity();
        let one = Matrix3::identity();
        f.set_rows(P, &[(P, one), (THETA, by_attitude), (V, r * dt), (A, r * (0.5 * dt * dt))]);
        f.set_rows(THETA, &[(THETA, back), (OMEGA, by_rate)]);
        f.set_rows(V, &[(V, one), (A, one * dt)]);
        let mut p = belief.mean.fixed_rows_mut::<3>(P);
        p += r * displacement;
        let mut v = belief.mean.fixed_rows_mut::<3>(V);
        v += acceleration * dt;
        belief.attitude = turned(belief.attitude, &turn);
        belief.propagate(&f);
        NOISE.iter().enumerate().for_each(|(i, q)| belief.add_noise(i, q * dt));
        witness.predicted(&f);
    }

    fn aid(
        &self,
        belief: &mut Belief<N>,
        _: &Interval,
        interval: &Interval,
        witness: &mut impl Witness<N>,
    ) {
        let Some(imu) = &interval.inertial else { return };
        let sensors = &self.parameters.sensors;
        let measured = [
            (OMEGA, imu.rate_end, sensors.gyro.noise_density, 0.0),
            (A, imu.specific_force, sensors.accelerometer.noise_density, self.parameters.gravity),
        ];
        for (state, value, density, gravity) in measured {
            let down = matrix(belief.attitude).transpose() * Vector3::z() * gravity;
            let mut predicted = Linearized::<2>::constant(block(belief, state) - down);
            predicted.set_block(state, &Matrix3::identity());
            predicted.set_block(THETA, &-skew(&down));
            let innovation = Vector3::from(value) - predicted.value;
            let mut observation = Observation::empty(3);
            observation.innovation = innovation.into();
            observation.variance = [(density * density / interval.dt).max(1e-12); 3];
            for (i, row) in observation.rows.iter_mut().enumerate() {
                predicted.add_to(row, &Vector3::ith(i, 1.0));
            }
            let correction = fuse(belief, &observation, f64::INFINITY, witness);
            self.correct(belief, &correction);
        }
    }

    fn motion(&self, belief: &Belief<N>, _: &Interval) -> Motion {
        Motion {
            position: block(belief, P),
            rotation: matrix(belief.attitude),
            velocity: block(belief, V),
            rate: block(belief, OMEGA),
            acceleration: block(belief, A),
        }
    }

    fn kinematics(&self, belief: &Belief<N>, interval: &Interval) -> Kinematics<N> {
        let motion = <Self as Process<N>>::motion(self, belief, interval);
        let turn = Block::new(THETA, Matrix3::identity());
        let mut k = Kinematics::new(&motion, turn, self.sensors, &belief.mean);
        k.position.set_block(P, &Matrix3::identity());
        k.velocity.set_block(V, &Matrix3::identity());
        k.rate.set_block(OMEGA, &Matrix3::identity());
        k.acceleration.set_block(A, &Matrix3::identity());
        k
    }

    fn align(&self, belief: &mut Belief<N>, euler: [f64; 3]) {
        belief.attitude = attitude::from_euler(euler);
    }

    fn velocity(&self) -> usize {
        V
    }

    fn correct(&self, belief: &mut Belief<N>, correction: &Column<N>) {
        belief.mean += correction;
        turn_attitude(belief, THETA);
        if let Some(state) = self.sensors.heading_bias {
            belief.mean[state] = attitude::wrap(belief.mean[state]);
        }
    }
}
