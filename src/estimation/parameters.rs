//! Parameters of the navigation filters and their validation.

use crate::ParameterError;
use crate::axes;
use crate::error::declared;
use crate::sensors::{BiasNoise, ImuGrade, ImuNoise};
use core::f64::consts::PI;
use fmu_quantity::Variables;

use super::kinematics::SensorStates;

/// The filter's assumptions about the sensors, in the sensors' terms.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct SensorErrors {
    /// Grade that gives accelerometer, gyro and tilt_sigma where they are not set
    ///
    /// Only [`SensorErrors::of`] uses it.
    pub imu_grade: ImuGrade,
    /// Accelerometers
    #[var(
        unit = "m/s2",
        unit_of(noise_density = "m/(s2.Hz0.5)", random_walk = "m/(s3.Hz0.5)"),
        start = ImuGrade::default().noise().accelerometer
    )]
    pub accelerometer: BiasNoise,
    /// Gyros
    #[var(
        unit = "rad/s",
        unit_of(noise_density = "rad/(s.Hz0.5)", random_walk = "rad/(s2.Hz0.5)"),
        start = ImuGrade::default().noise().gyro
    )]
    pub gyro: BiasNoise,
    /// Standard deviation of roll and pitch of the attitude reference
    #[var(unit = "rad", min = 1e-9, start = 0.01)]
    pub tilt_sigma: f64,
    /// Standard deviation of its heading
    #[var(unit = "rad", min = 1e-9, start = 0.01)]
    pub heading_sigma: f64,
    /// Standard deviation of the constant error of the heading; 0: none, not estimated
    #[var(unit = "rad", min = 0.0, start = 0.0087)]
    pub heading_bias_sigma: f64,
    /// Standard deviation of the velocity log, each axis
    #[var(unit = "m/s", min = 1e-9, start = 0.01)]
    pub dvl_sigma: f64,
    /// Standard deviation of its relative error; 0: none, not estimated
    #[var(unit = "1", min = 0.0)]
    pub dvl_scale_sigma: f64,
    /// Standard deviation of the yaw of its housing; 0: none, not estimated
    #[var(unit = "rad", min = 0.0)]
    pub dvl_misalignment_sigma: f64,
    /// Standard deviation of its delay against the attitude; 0: none, not estimated
    #[var(unit = "s", min = 0.0)]
    pub dvl_delay_sigma: f64,
    /// Standard deviation of a fix that does not report its own
    #[var(unit = "m", min = 1e-9, start = 0.5)]
    pub fix_sigma: f64,
    /// Standard deviation of the depth
    #[var(unit = "m", min = 1e-9, start = 0.306)]
    pub depth_sigma: f64,
}

/// Positions of the sensors, body.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Mounting {
    /// inertial unit
    #[var(unit = "m", elements = axes::BODY)]
    pub imu: [f64; 3],
    /// velocity log
    #[var(unit = "m", elements = axes::BODY, start = [-1.4, 0.0, 0.312])]
    pub dvl: [f64; 3],
    /// antenna or transponder of the fix
    #[var(unit = "m", elements = axes::BODY)]
    pub fix: [f64; 3],
    /// pressure sensor
    #[var(unit = "m", elements = axes::BODY, start = [-1.32, -0.5, -0.85])]
    pub pressure: [f64; 3],
}

/// Assumptions at the start.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Start {
    /// pose
    #[var(rename = "pose", elements = axes::NED, start = [0.0, 0.0, 20.0])]
    pub position: [f64; 3],
    /// pose
    ///
    /// Its part roll, pitch, yaw.
    #[var(rename = "pose", elements = axes::EULER)]
    pub attitude: [f64; 3],
    /// velocity over ground, body frame
    #[var(elements = axes::LINEAR_VELOCITY)]
    pub velocity: [f64; 3],
    /// standard deviation
    ///
    /// Of the position.
    #[var(rename = "sigma", min = 1e-6, elements = axes::NED, start = [0.5, 0.5, 10.0])]
    pub position_sigma: [f64; 3],
    /// standard deviation: roll and pitch
    #[var(rename = "sigma.tilt", unit = "rad", min = 1e-6, start = 0.2)]
    pub tilt_sigma: f64,
    /// standard deviation: yaw; from 0.5 on the first heading measured becomes the estimate
    ///
    /// The heading then counts as unknown, and the first measured attitude becomes the mean.
    #[var(rename = "sigma.yaw", unit = "rad", min = 1e-6, start = PI)]
    pub heading_sigma: f64,
    /// standard deviation: velocity, each axis
    #[var(rename = "sigma.velocity", unit = "m/s", min = 1e-6, start = 1.0)]
    pub velocity_sigma: f64,
}

/// Disturbances besides the vehicle model, for filters that have one.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct Disturbances {
    /// standard deviation of the force that varies quickly, each axis
    #[var(unit = "N", min = 0.0, start = 20.0)]
    pub force_sigma: f64,
    /// standard deviation of the yaw moment that varies quickly
    #[var(unit = "N.m", min = 0.0, start = 10.0)]
    pub moment_sigma: f64,
    /// correlation time of both
    #[var(unit = "s", min = 1e-6, start = 5.0)]
    pub correlation_time: f64,
    /// density of the white force
    #[var(unit = "N/Hz0.5", min = 1e-9, start = 10.0)]
    pub force_density: f64,
    /// density of the white yaw moment
    #[var(unit = "N.m/Hz0.5", min = 1e-9, start = 10.0)]
    pub moment_density: f64,
    /// standard deviation of the current at the start, each axis
    #[var(unit = "m/s", min = 0.0, start = 0.3)]
    pub current_sigma: f64,
    /// density of the random walk of the current
    #[var(unit = "m/(s2.Hz0.5)", min = 0.0, nominal = 0.001, start = 1e-3)]
    pub current_walk: f64,
}

/// Disturbances, and errors of the vehicle model itself.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct ModelErrors {
    /// What varies.
    #[var(flatten)]
    pub disturbances: Disturbances,
    /// standard deviation of the force that varies slowly, each axis: errors of damping and thrust
    #[var(unit = "N", min = 0.0, start = 5.0)]
    pub slow_force_sigma: f64,
    /// correlation time of the force that varies slowly
    #[var(unit = "s", min = 1e-6, start = 1000.0)]
    pub slow_force_time: f64,
    /// relative error of the forces that thrusters make
    #[var(unit = "1", min = 0.0, start = 0.1)]
    pub thrust_error: f64,
}

/// Parameters that all navigation filters have.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct NavigationParameters {
    /// Longest interval of prediction
    #[var(rename = "prediction_interval", unit = "s", min = 0.01, max = 1.0, start = 0.1)]
    pub interval: f64,
    /// How late a measurement may come and still be put in its place
    #[var(unit = "s", min = 0.0, max = 3600.0, start = 2.5)]
    pub latency: f64,
    /// Whether the influence of outliers is limited
    #[var(rename = "outlier_limit", start = true)]
    pub gated: bool,
    /// Errors of the sensors.
    #[var(flatten)]
    pub sensors: SensorErrors,
    /// Place in the body frame
    pub mounting: Mounting,
    /// Start
    #[var(rename = "initial")]
    pub start: Start,
    /// Acceleration of gravity
    #[var(unit = "m/s2", min = 0.0, start = 9.81)]
    pub gravity: f64,
    /// Manoeuvres while the inertial unit is silent: density of its white acceleration
    #[var(rename = "maneuver.acceleration", unit = "m/(s2.Hz0.5)", min = 1e-9, start = 0.2)]
    pub maneuver_acceleration: f64,
    /// Manoeuvres while the inertial unit is silent: density of its white angular rate
    #[var(rename = "maneuver.rate", unit = "rad/(s.Hz0.5)", min = 1e-9, start = 0.2)]
    pub maneuver_rate: f64,
}

impl NavigationParameters {
    /// With an inertial unit of a grade.
    #[must_use]
    pub fn of(imu_grade: ImuGrade) -> Self {
        Self { sensors: SensorErrors::of(imu_grade), ..Self::default() }
    }

    /// # Errors
    /// Names the parameter that is out of range.
    pub fn check(&self) -> Result<(), ParameterError> {
        declared(self)
    }
}

impl SensorErrors {
    /// The noise of an inertial unit and of the roll and pitch that it gives.
    #[must_use]
    pub fn of(imu_grade: ImuGrade) -> Self {
        let ImuNoise { accelerometer, gyro, attitude_sigma } = imu_grade.noise();
        Self { imu_grade, accelerometer, gyro, tilt_sigma: attitude_sigma, ..Self::default() }
    }

    /// Numbers the sensor states, starting at `base`: the states, their standard deviations, and
    /// the total number of states.
    pub(super) fn states(&self, base: usize) -> (SensorStates, [(usize, f64); 4], usize) {
        let mut next = base;
        let mut sigmas = [(0, 0.0); 4];
        let mut state = |index: usize, sigma: f64| {
            (sigma > 0.0).then(|| {
                sigmas[index] = (next, sigma);
                next += 1;
                next - 1
            })
        };
        let states = SensorStates {
            heading_bias: state(0, self.heading_bias_sigma),
            dvl_scale: state(1, self.dvl_scale_sigma),
            dvl_misalignment: state(2, self.dvl_misalignment_sigma),
            dvl_delay: state(3, self.dvl_delay_sigma),
        };
        (states, sigmas, next)
    }
}

impl Disturbances {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn check(&self) -> Result<(), ParameterError> {
        declared(self).map_err(|error| error.within("disturbance"))
    }
}

impl ModelErrors {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn check(&self) -> Result<(), ParameterError> {
        declared(self).map_err(|error| error.within("disturbance"))
    }
}
