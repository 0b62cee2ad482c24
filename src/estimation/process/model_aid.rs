//! Aiding by the equations of motion: balances of force and moment as measurements.
//!
//! The inertial unit drives the filter. The rigid-body model predicts the specific force and the
//! change of the yaw rate from thrust, damping, added mass and buoyancy. Hegrenæs & Hallingstad
//! (2011) aid by a velocity; using the forces themselves separates the noise of the inertial unit
//! from that of the model. The accelerometers' mean that drives an interval also enters its force
//! balance, so its noise is a state for the duration of the interval (likewise the gyro's about z,
//! for two intervals): correlated noise, fused exactly.
//!
//! Through the Munk moment, the moment balance observes sway, which nothing else does while the
//! velocity log is silent.

use nalgebra::{Matrix3, Vector3};

use super::inertial::{B_A, B_G, Strapdown, THETA, U};
use super::rotation::{exp, matrix, right_jacobian};
use crate::ParameterError;
use crate::estimation::belief::{Belief, Column, Row};
use crate::estimation::interval::{Inertial, Interval, Thrusts};
use crate::estimation::kalman::{Witness, fuse};
use crate::estimation::kinematics::skew;
use crate::estimation::parameters::{ModelErrors, NavigationParameters};
use crate::estimation::sensor::Observation;
use crate::estimation::transition::Transition;
use crate::vehicle::Parameters;

/// NIS at which the influence of a balance is limited: three standard deviations.
const BALANCE_GATE: f64 = 9.0;

/// The states of the aid.
#[derive(Clone, Copy, Debug)]
pub struct AidStates {
    /// Current north and east (m/s).
    pub current: usize,
    /// Fast force, body (N).
    pub force: usize,
    /// Slow force, body (N).
    pub slow_force: usize,
    /// Fast yaw moment (N.m).
    pub moment: usize,
    /// Noise of the accelerometers' mean in this interval (m/s2).
    pub force_noise: usize,
    /// Noise of the yaw gyro's mean in this interval (rad/s).
    pub rate_noise: usize,
    /// The same in the previous interval.
    pub rate_noise_before: usize,
}

impl AidStates {
    /// How many states there are.
    pub const COUNT: usize = 14;

    /// Numbered starting at `base`.
    #[must_use]
    pub const fn at(base: usize) -> Self {
        Self {
            current: base,
            force: base + 2,
            slow_force: base + 5,
            moment: base + 8,
            force_noise: base + 9,
            rate_noise: base + 12,
            rate_noise_before: base + 13,
        }
    }
}

/// The rigid-body model and its assumed accuracy.
#[derive(Clone, Debug)]
pub struct ModelAid {
    errors: ModelErrors,
    /// Mass including added mass along x, y, z (kg).
    mass: Vector3<f64>,
    /// Inertia including added inertia about z (kg.m2).
    inertia: f64,
    /// Rows 1 to 3 of M: momentum of velocity and of angular rate.
    momentum: [Matrix3<f64>; 2],
    linear: [f64; 4],
    quadratic: [f64; 4],
    excess_weight: f64,
    gravity: f64,
    /// Force and yaw moment of one newton of each thruster.
    thrusters: [[f64; 4]; 8],
}

impl ModelAid {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &Parameters, errors: &ModelErrors) -> Result<Self, ParameterError> {
        p.check()?;
        errors.check()?;
        let m = p.mass_matrix();
        let pick = |d: &[f64; 6]| [d[0], d[1], d[2], d[5]];
        Ok(Self {
            errors: *errors,
            mass: Vector3::new(m[0][0], m[1][1], m[2][2]),
            inertia: m[5][5],
            momentum: [0, 3].map(|from| Matrix3::from_fn(|i, j| m[i][from + j])),
            linear: pick(&p.linear_damping),
            quadratic: pick(&p.quadratic_damping),
            excess_weight: p.weight() - p.buoyancy_force(),
            gravity: p.gravity,
            thrusters: p.propulsion.thrusters.map(|t| pick(&t.unit_wrench())),
        })
    }

    pub(super) fn start<const N: usize>(&self, sigma: &mut Column<N>, at: AidStates) {
        let (e, d) = (&self.errors, &self.errors.disturbances);
        for i in 0..2 {
            sigma[at.current + i] = d.current_sigma;
        }
        for i in 0..3 {
            sigma[at.force + i] = d.force_sigma;
            sigma[at.slow_force + i] = e.slow_force_sigma;
        }
        sigma[at.moment] = d.moment_sigma;
    }

    /// The noise states of a new interval: the yaw gyro's is kept as that of the previous interval.
    pub(super) fn renew_noise<const N: usize>(
        &self,
        belief: &mut Belief<N>,
        at: AidStates,
        dt: f64,
        p: &NavigationParameters,
        witness: &mut impl Witness<N>,
    ) {
        let mut f = Transition::identity();
        f.set_row(at.rate_noise_before, [(at.rate_noise, 1.0)]);
        f.scale(at.rate_noise, 0.0);
        (0..3).for_each(|i| f.scale(at.force_noise + i, 0.0));
        belief.propagate(&f);
        belief.mean = f.apply(&belief.mean);
        witness.predicted(&f);
        let variance = |density: f64| density * density / dt;
        for i in 0..3 {
            belief.add_noise(at.force_noise + i, variance(p.sensors.accelerometer.noise_density));
        }
        belief.add_noise(at.rate_noise, variance(p.sensors.gyro.noise_density));
    }

    /// The remaining share of the fast and slow forces after an interval.
    pub(super) fn decays(&self, dt: f64) -> [f64; 2] {
        let (e, d) = (&self.errors, &self.errors.disturbances);
        [d.correlation_time, e.slow_force_time].map(|time| libm::exp(-dt / time))
    }

    /// Applies the decay of the forces in F and in the mean.
    pub(super) fn decay<const N: usize>(
        &self,
        f: &mut Transition<N>,
        x: &mut Column<N>,
        at: AidStates,
        [quick, slow]: [f64; 2],
    ) {
        for i in 0..3 {
            x[at.force + i] *= quick;
            x[at.slow_force + i] *= slow;
            f.scale(at.force + i, quick);
            f.scale(at.slow_force + i, slow);
        }
        f.scale(at.moment, quick);
        x[at.moment] *= quick;
    }

    pub(super) fn add_noise<const N: usize>(
        &self,
        belief: &mut Belief<N>,
        at: AidStates,
        dt: f64,
        [quick, slow]: [f64; 2],
    ) {
        let (e, d) = (&self.errors, &self.errors.disturbances);
        let stationary = |sigma: f64, decay: f64| sigma * sigma * (1.0 - decay * decay);
        for i in 0..3 {
            belief.add_noise(at.force + i, stationary(d.force_sigma, quick));
            belief.add_noise(at.slow_force + i, stationary(e.slow_force_sigma, slow));
        }
        belief.add_noise(at.moment, stationary(d.moment_sigma, quick));
        for i in 0..2 {
            belief.add_noise(at.current + i, d.current_walk * d.current_walk * dt);
        }
    }

    /// Fuses the balances of an interval.
    pub(super) fn balance<const N: usize>(
        &self,
        belief: &mut Belief<N>,
        at: AidStates,
        before: &Interval,
        interval: &Interval,
        correct: impl Fn(&mut Belief<N>, &Column<N>),
        witness: &mut impl Witness<N>,
    ) {
        let (Some(imu), Some(thrusts)) = (&interval.inertial, &interval.thrust) else { return };
        let force = self.force_balance(belief, at, imu, thrusts, interval.dt);
        let correction = fuse(belief, &force, BALANCE_GATE, witness);
        correct(belief, &correction);
        let (Some(imu_before), Some(thrusts_before)) = (&before.inertial, &before.thrust) else {
            return;
        };
        let pair = [(imu_before, thrusts_before, before.dt), (imu, thrusts, interval.dt)];
        let moment = self.moment_balance(belief, at, pair);
        let correction = fuse(belief, &moment, BALANCE_GATE, witness);
        correct(belief, &correction);
    }

    /// Component `axis` (0 to 2: force, 3: yaw moment) of thrusts (N).
    fn thrust(&self, forces: &[f64; 8], axis: usize) -> f64 {
        self.thrusters.iter().zip(forces).map(|(unit, force)| unit[axis] * force).sum()
    }

    /// Specific force predicted by the model at the middle of the interval, compared with the
    /// measured one.
    pub fn force_balance<const N: usize>(
        &self,
        belief: &Belief<N>,
        at: AidStates,
        imu: &Inertial,
        thrusts: &Thrusts,
        dt: f64,
    ) -> Observation<N> {
        let x = &belief.mean;
        let s = Strapdown::new(belief, imu);
        let noise: Vector3<f64> = x.fixed_rows::<3>(at.force_noise).into_owned();
        let water = Water::new(belief, at, &s, &noise, self.gravity, [dt, 0.5]);
        let (w, nu) = (&s.rate, &water.velocity);
        let momentum = self.momentum[0] * nu + self.momentum[1] * w;
        let damping =
            Vector3::from_fn(|i, _| (self.linear[i] + self.quadratic[i] * nu[i].abs()) * nu[i]);
        let thrust = Vector3::from_fn(|i, _| self.thrust(&thrusts.mean, i));
        let disturbance = x.fixed_rows::<3>(at.force) + x.fixed_rows::<3>(at.slow_force);
        let force =
            -w.cross(&momentum) - damping + water.down * self.excess_weight + thrust + disturbance;
        let per_mass = self.mass.map(|m| 1.0 / m);
        let bias: Vector3<f64> = x.fixed_rows::<3>(B_A).into_owned();
        let predicted =
            force.component_mul(&per_mass) + w.cross(nu) - water.down * self.gravity + bias + noise;

        let per_mass = Matrix3::from_diagonal(&per_mass);
        let slope = Matrix3::from_diagonal(&Vector3::from_fn(|i, _| {
            self.linear[i] + 2.0 * self.quadratic[i] * nu[i].abs()
        }));
        let by_velocity = per_mass * (-skew(w) * self.momentum[0] - slope) + skew(w);
        let by_rate = per_mass * (skew(&momentum) - skew(w) * self.momentum[1]) - skew(nu);
        let by_down = per_mass * self.excess_weight - Matrix3::identity() * self.gravity;
        let mut rows = water.rows(at, &by_velocity, &by_down, &by_rate);
        for (i, row) in rows.iter_mut().enumerate() {
            row[B_A + i] += 1.0;
            row[at.force_noise + i] += 1.0;
            row[at.force + i] = per_mass[(i, i)];
            row[at.slow_force + i] = per_mass[(i, i)];
        }
        let (e, d) = (&self.errors, &self.errors.disturbances);
        let square = |x: f64| x * x;
        Observation::new(
            3,
            core::array::from_fn(|i| imu.specific_force[i] - predicted[i]),
            rows,
            core::array::from_fn(|i| {
                let white = square(d.force_density * per_mass[(i, i)]) / dt;
                white + square(e.thrust_error * thrust[i] * per_mass[(i, i)])
            }),
        )
    }

    /// Change of the yaw rate between two intervals predicted by the model, compared with the
    /// measured one.
    pub fn moment_balance<const N: usize>(
        &self,
        belief: &Belief<N>,
        at: AidStates,
        [(imu_before, thrusts_before, dt_before), (imu, thrusts, dt)]: [(&Inertial, &Thrusts, f64);
            2],
    ) -> Observation<N> {
        let x = &belief.mean;
        let spacing = 0.5 * (dt_before + dt);
        let weights = [dt / (dt + dt_before), dt_before / (dt + dt_before)];
        let raw =
            Vector3::from(imu_before.rate) * weights[0] + Vector3::from(imu.rate) * weights[1];
        let w = raw - x.fixed_rows::<3>(B_G);
        let s = Strapdown::new(belief, imu);
        let noise: Vector3<f64> = x.fixed_rows::<3>(at.force_noise).into_owned();
        let water = Water::new(belief, at, &s, &noise, self.gravity, [dt, 1.0]);
        let nu = &water.velocity;
        let momentum = self.momentum[0] * nu + self.momentum[1] * w;
        // The difference of two means is the mean with a triangular weight.
        let late = self.thrust(&thrusts_before.rising, 3) * dt_before;
        let early = (self.thrust(&thrusts.mean, 3) - self.thrust(&thrusts.rising, 3)) * dt;
        let thrust = (late + early) / spacing;
        let damping = (self.linear[3] + self.quadratic[3] * w.z.abs()) * w.z;
        let munk = momentum.x * nu.y - momentum.y * nu.x;
        let per_inertia = 1.0 / self.inertia;
        let predicted = (munk - damping + thrust + x[at.moment]) * per_inertia
            + (x[at.rate_noise] - x[at.rate_noise_before]) / spacing;

        let by_momentum = nalgebra::RowVector3::new(nu.y, -nu.x, 0.0);
        let direct = nalgebra::RowVector3::new(-momentum.y, momentum.x, 0.0);
        let mut by_velocity = Matrix3::zeros();
        by_velocity.set_row(0, &((by_momentum * self.momentum[0] + direct) * per_inertia));
        let mut by_rate = Matrix3::zeros();
        let slope = self.linear[3] + 2.0 * self.quadratic[3] * w.z.abs();
        by_rate.set_row(0, &(by_momentum * self.momentum[1] * per_inertia));
        by_rate[(0, 2)] -= slope * per_inertia;
        let mut rows = water.rows(at, &by_velocity, &Matrix3::zeros(), &by_rate);
        rows[0][at.moment] = per_inertia;
        rows[0][at.rate_noise] += 1.0 / spacing;
        rows[0][at.rate_noise_before] -= 1.0 / spacing;
        let measured = (imu.rate[2] - imu_before.rate[2]) / spacing;
        let (e, d) = (&self.errors, &self.errors.disturbances);
        let square = |x: f64| x * x;
        let variance = square(d.moment_density * per_inertia) / spacing
            + square(e.thrust_error * thrust * per_inertia);
        Observation::new(1, [measured - predicted, 0.0, 0.0], rows, [variance, 1.0, 1.0])
    }
}

/// Velocity through the water at some time before the end of the interval, and its derivatives.
struct Water {
    velocity: Vector3<f64>,
    /// Down along body axes.
    down: Vector3<f64>,
    /// Derivatives of the velocity: by the velocity over ground, by the current (NED), by a
    /// rotation there.
    by_ground: Matrix3<f64>,
    inverse: Matrix3<f64>,
    by_turn: Matrix3<f64>,
    /// The rotation there by the rotation at the end, and by the gyro bias.
    turn: Matrix3<f64>,
    turn_by_bias: Matrix3<f64>,
    /// Derivatives by the force biases, and directly by the gyro bias.
    by_force: Matrix3<f64>,
    by_bias: Matrix3<f64>,
}

impl Water {
    /// `share` of the interval before its end.
    ///
    /// `nu = Exp(w t) u - R_b^T (c + g e_z t) - Exp(w (t - dt/2)) f t` with `R_b = R Exp(-w t)` and
    /// `t = share dt`; f is the force minus its bias and noise.
    fn new<const N: usize>(
        belief: &Belief<N>,
        at: AidStates,
        s: &Strapdown,
        noise: &Vector3<f64>,
        gravity: f64,
        [dt, share]: [f64; 2],
    ) -> Self {
        let t = share * dt;
        let forth = s.rate * t;
        let by_ground = exp(&forth);
        let inverse = by_ground * matrix(belief.attitude).transpose();
        let current = Vector3::new(belief.mean[at.current], belief.mean[at.current + 1], 0.0);
        let ground: Vector3<f64> = belief.mean.fixed_rows::<3>(U).into_owned();
        // Gravity and force act in the frame of the middle of the interval.
        let force = s.force - noise;
        let ahead = s.rate * (t - 0.5 * dt);
        let to_middle = exp(&ahead);
        let down = inverse * Vector3::z();
        let fixed = -inverse * current - down * (gravity * t);
        let by_bias = to_middle * skew(&force) * right_jacobian(&ahead) * (-(t - 0.5 * dt) * t);
        Self {
            velocity: by_ground * ground + fixed - to_middle * force * t,
            down,
            by_ground,
            inverse,
            by_turn: skew(&fixed),
            turn: by_ground,
            turn_by_bias: right_jacobian(&-forth) * t,
            by_force: to_middle * t,
            by_bias: by_bias + by_ground * skew(&ground) * right_jacobian(&forth) * t,
        }
    }

    /// Rows of `A nu + D down + C w`, A `by_velocity`, D `by_down`, C `by_rate`.
    fn rows<const N: usize>(
        &self,
        at: AidStates,
        by_velocity: &Matrix3<f64>,
        by_down: &Matrix3<f64>,
        by_rate: &Matrix3<f64>,
    ) -> [Row<N>; 3] {
        let ground = by_velocity * self.by_ground;
        let current = -by_velocity * self.inverse;
        let turn = by_velocity * self.by_turn + by_down * skew(&self.down);
        let attitude = turn * self.turn;
        let bias = turn * self.turn_by_bias + by_velocity * self.by_bias - by_rate;
        let force = by_velocity * self.by_force;
        let mut rows = Row::NONE;
        for (i, row) in rows.iter_mut().enumerate() {
            for j in 0..3 {
                row[U + j] = ground[(i, j)];
                row[THETA + j] = attitude[(i, j)];
                row[B_G + j] = bias[(i, j)];
                row[B_A + j] = force[(i, j)];
                row[at.force_noise + j] = force[(i, j)];
            }
            for j in 0..2 {
                row[at.current + j] = current[(i, j)];
            }
        }
        rows
    }
}
