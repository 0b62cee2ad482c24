//! The motion of the vehicle as every process provides it, with its derivatives by the states.
//!
//! Sensors are written once for this interface, whatever the states of the process: a row of a
//! measurement's Jacobian is the chain rule through position, attitude, velocity and rate.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::belief::{Column, Row};
use super::process::rotation::exp;

/// Derivatives of a vector by three consecutive states, starting with `state`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Block {
    state: usize,
    by: Matrix3<f64>,
}

impl Block {
    /// Element (i, j) of the matrix is the derivative of component i by `state + j`.
    #[must_use]
    pub fn new(state: usize, by: Matrix3<f64>) -> Self {
        Self { state, by }
    }

    /// The derivatives of `M v` of this vector v.
    #[must_use]
    #[inline]
    pub fn through(&self, m: &Matrix3<f64>) -> Self {
        Self { state: self.state, by: m * self.by }
    }

    /// Adds `a^T v` of the vector v to a row.
    pub fn add_to<const N: usize>(&self, row: &mut Row<N>, a: &Vector3<f64>) {
        let by = self.by.tr_mul(a);
        for (j, &value) in by.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            row[self.state + j] += value;
        }
    }
}

/// A vector and its derivatives by the states of up to `B` blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearized<const B: usize = 1> {
    /// The vector.
    pub value: Vector3<f64>,
    blocks: [Block; B],
    count: usize,
}

impl<const B: usize> Linearized<B> {
    /// A vector that does not depend on the states.
    #[must_use]
    #[inline]
    pub fn constant(value: Vector3<f64>) -> Self {
        Self { value, blocks: [Block::default(); B], count: 0 }
    }

    /// Sets the derivatives by three consecutive states, starting at `state`, which has none yet.
    ///
    /// # Panics
    /// If there are `B` blocks already.
    pub fn set_block(&mut self, state: usize, by: &Matrix3<f64>) {
        self.add_block(&Block::new(state, *by));
    }

    /// Adds derivatives.
    ///
    /// # Panics
    /// If there are `B` blocks already.
    pub fn add_block(&mut self, block: &Block) {
        self.blocks[self.count] = *block;
        self.count += 1;
    }

    /// Adds the derivatives of `M v` of another vector v.
    ///
    /// # Panics
    /// If there would be too many blocks.
    pub fn add<const C: usize>(&mut self, m: &Matrix3<f64>, v: &Linearized<C>) {
        v.blocks[..v.count].iter().for_each(|block| self.add_block(&block.through(m)));
    }

    /// Covariance with another vector, where `p` is the covariance of the states.
    #[must_use]
    #[inline]
    pub fn covariance<const C: usize, const N: usize>(
        &self,
        other: &Linearized<C>,
        p: &SMatrix<f64, N, N>,
    ) -> Matrix3<f64> {
        let mut sum = Matrix3::zeros();
        for a in &self.blocks[..self.count] {
            for b in &other.blocks[..other.count] {
                let states = p.fixed_view::<3, 3>(a.state, b.state);
                sum += a.by * states * b.by.transpose();
            }
        }
        sum
    }

    /// Adds the derivatives of `a^T v` of this vector v to a row.
    pub fn add_to<const N: usize>(&self, row: &mut Row<N>, a: &Vector3<f64>) {
        self.blocks[..self.count].iter().for_each(|block| block.add_to(row, a));
    }
}

/// Sensor states, if a process has them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorStates {
    /// Bias of the compass (rad): it reports the heading plus this.
    pub heading_bias: Option<usize>,
    /// Scale error of the velocity log: it reports 1 + this times the velocity.
    pub dvl_scale: Option<usize>,
    /// Yaw of the velocity log's housing (rad).
    pub dvl_misalignment: Option<usize>,
    /// Delay of the velocity log (s): a sample stamped t contains the velocity at t minus this, by
    /// the clock of the attitude.
    pub dvl_delay: Option<usize>,
}

impl SensorStates {
    /// States that a velocity log cannot distinguish from a change of the velocity.
    #[must_use]
    pub fn of_dvl(&self) -> [Option<usize>; 3] {
        [self.dvl_scale, self.dvl_misalignment, self.dvl_delay]
    }
}

/// Motion at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Position of the centre of gravity, NED (m).
    pub position: Vector3<f64>,
    /// Rotation from body to NED.
    pub rotation: Matrix3<f64>,
    /// Velocity over ground, body (m/s).
    pub velocity: Vector3<f64>,
    /// Angular rate, body (rad/s).
    pub rate: Vector3<f64>,
    /// Time derivative of the velocity along body axes (m/s2).
    pub acceleration: Vector3<f64>,
}

impl Motion {
    /// The motion `lag` seconds later, at constant acceleration and rate.
    #[must_use]
    pub fn after(&self, lag: f64) -> Self {
        let inertial = self.acceleration + self.rate.cross(&self.velocity);
        let along = self.velocity * lag + inertial * (0.5 * lag * lag);
        Self {
            position: self.position + self.rotation * along,
            rotation: self.rotation * exp(&(self.rate * lag)),
            velocity: self.velocity + self.acceleration * lag,
            ..*self
        }
    }
}

/// Motion at an instant with its derivatives by the states of a process.
#[derive(Clone, Copy, Debug)]
pub struct Kinematics<const N: usize> {
    /// Position of the centre of gravity, NED (m).
    pub position: Linearized,
    /// Rotation from body to NED.
    pub rotation: Matrix3<f64>,
    /// A small rotation about the body axes (rad): its value is zero, these are its derivatives.
    pub turn: Block,
    /// Velocity over ground, body (m/s).
    pub velocity: Linearized,
    /// Angular rate, body (rad/s).
    pub rate: Linearized,
    /// Variance of the rate's noise in addition to that of the states ((rad/s)^2).
    pub rate_variance: f64,
    /// Variance of the error of a rate that was tracked from attitudes ((rad/s)^2). It accumulates
    /// to no more than the noise of an attitude, so no measurement gets less weight because of it.
    pub tracking_variance: f64,
    /// Time derivative of the velocity along body axes (m/s2). It is for the delay of the velocity
    /// log, and may be omitted if that is not a state.
    pub acceleration: Linearized<4>,
    /// States of the sensors, and their mean.
    pub sensors: SensorStates,
    /// Mean of all states.
    pub mean: Column<N>,
}

impl<const N: usize> Kinematics<N> {
    /// A motion without derivatives, which the caller adds in place, except those of a rotation.
    #[must_use]
    #[inline]
    pub fn new(motion: &Motion, turn: Block, sensors: SensorStates, mean: &Column<N>) -> Self {
        Self {
            position: Linearized::constant(motion.position),
            rotation: motion.rotation,
            turn,
            velocity: Linearized::constant(motion.velocity),
            rate: Linearized::constant(motion.rate),
            rate_variance: 0.0,
            tracking_variance: 0.0,
            acceleration: Linearized::constant(motion.acceleration),
            sensors,
            mean: *mean,
        }
    }

    /// Mean of an optional state; zero where it does not exist.
    #[must_use]
    pub fn optional(&self, state: Option<usize>) -> f64 {
        state.map_or(0.0, |i| self.mean[i])
    }

    /// Derivatives of `a^T dtheta`, for quantities that depend on the attitude.
    #[must_use]
    pub fn through_rotation(&self, a: &Vector3<f64>) -> Row<N> {
        let mut row = Row::zeros();
        self.turn.add_to(&mut row, a);
        row
    }

    /// Position of a point fixed to the body at `lever` (m), NED.
    #[must_use]
    pub fn point(&self, lever: &Vector3<f64>) -> Vector3<f64> {
        self.position.value + self.rotation * lever
    }

    /// Adds the derivatives of its component i to a row.
    pub fn add_point_to(&self, row: &mut Row<N>, lever: &Vector3<f64>, i: usize) {
        // R Exp(dtheta) l = R l - R [l]x dtheta, and -r^T [l]x = (l x r)^T.
        self.turn.add_to(row, &lever.cross(&self.rotation.row(i).transpose()));
        self.position.add_to(row, &Vector3::ith(i, 1.0));
    }
}

/// The matrix of the cross product: `skew(a) b = a x b`.
#[must_use]
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// The matrix with one column and zeros: a block in which only its first state matters.
#[must_use]
#[inline]
pub fn first_column(column: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[column, Vector3::zeros(), Vector3::zeros()])
}
