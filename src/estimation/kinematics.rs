//! What all processes know of the vehicle's motion, with its derivatives by their states.
//!
//! Sensors are written for this view once, whatever the states of the process: a row of a
//! measurement's Jacobian is the chain rule through position, attitude, velocity and rate.

use nalgebra::{Matrix3, Vector3};

use super::belief::Column;
use super::process::rotation::exp;

/// A vector and its derivatives: row i is the derivative of component i.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linearized<const N: usize> {
    /// The vector.
    pub value: Vector3<f64>,
    /// Derivatives by the states.
    pub rows: [Column<N>; 3],
}

impl<const N: usize> Linearized<N> {
    /// A vector that does not depend on the states.
    #[must_use]
    pub fn constant(value: Vector3<f64>) -> Self {
        Self { value, rows: [Column::zeros(); 3] }
    }

    /// Sets the derivatives by three states in a row, beginning at `state`.
    pub fn set_block(&mut self, state: usize, block: &Matrix3<f64>) {
        for (i, row) in self.rows.iter_mut().enumerate() {
            for j in 0..3 {
                row[state + j] = block[(i, j)];
            }
        }
    }

    /// `d(m v)` component i: the row of a linear image of this vector.
    #[must_use]
    pub fn image(&self, m: &Matrix3<f64>, i: usize) -> Column<N> {
        self.rows[0] * m[(i, 0)] + self.rows[1] * m[(i, 1)] + self.rows[2] * m[(i, 2)]
    }
}

/// States that belong to the sensors, where a process has them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorStates {
    /// Bias of the compass (rad): it shows the heading plus this.
    pub heading_bias: Option<usize>,
    /// Scale error of the velocity log: it shows 1 + this times the velocity.
    pub dvl_scale: Option<usize>,
    /// Yaw of the velocity log's housing (rad).
    pub dvl_misalignment: Option<usize>,
    /// Delay of the velocity log (s): a sample stamped t shows the velocity at t less this, by the
    /// clock of the attitude.
    pub dvl_delay: Option<usize>,
}

impl SensorStates {
    /// States that a velocity log cannot tell from a change of the velocity.
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
    pub position: Linearized<N>,
    /// Rotation from body to NED.
    pub rotation: Matrix3<f64>,
    /// Whether roll and pitch are taken from their sensor as they are, and only the heading is a state.
    pub tilt_is_input: bool,
    /// Derivatives of a small rotation about the body axes (rad); its value is zero.
    pub rotation_rows: [Column<N>; 3],
    /// Velocity over ground, body (m/s).
    pub velocity: Linearized<N>,
    /// Angular rate, body (rad/s).
    pub rate: Linearized<N>,
    /// Variance of the rate's noise beyond what the states say ((rad/s)^2).
    pub rate_variance: f64,
    /// Time derivative of the velocity along body axes (m/s2).
    pub acceleration: Linearized<N>,
    /// States of the sensors, and their mean.
    pub sensors: SensorStates,
    /// Mean of all states.
    pub mean: Column<N>,
}

impl<const N: usize> Kinematics<N> {
    /// Mean of an optional state; zero where it does not exist.
    #[must_use]
    pub fn optional(&self, state: Option<usize>) -> f64 {
        state.map_or(0.0, |i| self.mean[i])
    }

    /// Row of `m dtheta` component i, for derivatives through the attitude.
    #[must_use]
    pub fn through_rotation(&self, m: &Matrix3<f64>, i: usize) -> Column<N> {
        let [a, b, c] = &self.rotation_rows;
        a * m[(i, 0)] + b * m[(i, 1)] + c * m[(i, 2)]
    }

    /// Position of a point fixed to the body at `lever` (m), NED.
    #[must_use]
    pub fn point(&self, lever: &Vector3<f64>) -> Linearized<N> {
        // R Exp(dtheta) l = R l - R [l]x dtheta.
        let turn = -self.rotation * skew(lever);
        let mut point = self.position;
        point.value += self.rotation * lever;
        for (i, row) in point.rows.iter_mut().enumerate() {
            *row += self.through_rotation(&turn, i);
        }
        point
    }
}

/// The matrix of the cross product: `skew(a) b = a x b`.
#[must_use]
pub fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}
