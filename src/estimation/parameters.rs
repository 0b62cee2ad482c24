//! Parameters of the navigation filters and their validation.

use crate::ParameterError;
use crate::error::{each, finite, non_negative, positive};
use crate::sensors::{BiasNoise, ImuParameters};

use super::kinematics::SensorStates;

/// The filter's assumptions about the sensors, in the sensors' terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorErrors {
    /// Accelerometers (m/s2).
    pub accelerometer: BiasNoise,
    /// Gyros (rad/s).
    pub gyro: BiasNoise,
    /// Standard deviation of roll and pitch of the attitude reference (rad).
    pub tilt_sigma: f64,
    /// Standard deviation of its heading (rad).
    pub heading_sigma: f64,
    /// Standard deviation of the constant bias of the heading (rad); 0: none, no state for it.
    pub heading_bias_sigma: f64,
    /// Standard deviation of the velocity log, each axis (m/s).
    pub dvl_sigma: f64,
    /// Standard deviation of its scale error; 0: none, no state for it.
    pub dvl_scale_sigma: f64,
    /// Standard deviation of the yaw of its housing (rad); 0: none, no state for it.
    pub dvl_misalignment_sigma: f64,
    /// Standard deviation of its delay relative to the attitude (s); 0: none, no state for it.
    pub dvl_delay_sigma: f64,
    /// Standard deviation of a fix that does not report its own (m).
    pub fix_sigma: f64,
    /// Standard deviation of the depth (m).
    pub depth_sigma: f64,
}

impl Default for SensorErrors {
    fn default() -> Self {
        let imu = ImuParameters::default();
        Self {
            accelerometer: imu.accelerometer,
            gyro: imu.gyro,
            tilt_sigma: 0.01,
            heading_sigma: 0.01,
            heading_bias_sigma: 0.0087,
            dvl_sigma: 0.01,
            dvl_scale_sigma: 0.0,
            dvl_misalignment_sigma: 0.0,
            dvl_delay_sigma: 0.0,
            fix_sigma: 0.5,
            depth_sigma: 0.306,
        }
    }
}

/// Positions of the sensors, body (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Inertial unit.
    pub imu: [f64; 3],
    /// Velocity log.
    pub dvl: [f64; 3],
    /// Antenna or transponder of the fix.
    pub fix: [f64; 3],
    /// Pressure sensor.
    pub pressure: [f64; 3],
}

impl Default for Mounting {
    fn default() -> Self {
        Self {
            imu: [0.0; 3],
            dvl: [-1.4, 0.0, 0.312],
            fix: [0.0; 3],
            pressure: [-1.32, -0.5, -0.85],
        }
    }
}

/// Assumptions at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// `[x, y, z]` NED (m).
    pub position: [f64; 3],
    /// `[roll, pitch, yaw]` (rad).
    pub attitude: [f64; 3],
    /// Velocity over ground, body (m/s).
    pub velocity: [f64; 3],
    /// Standard deviations of the position (m).
    pub position_sigma: [f64; 3],
    /// Standard deviation of roll and pitch (rad).
    pub tilt_sigma: f64,
    /// Standard deviation of the heading (rad); from half a radian on it counts as unknown, and the
    /// first measured attitude becomes the mean.
    pub heading_sigma: f64,
    /// Standard deviation of the velocity, each axis (m/s).
    pub velocity_sigma: f64,
}

impl Default for Start {
    fn default() -> Self {
        Self {
            position: [0.0, 0.0, 20.0],
            attitude: [0.0; 3],
            velocity: [0.0; 3],
            position_sigma: [0.5, 0.5, 10.0],
            tilt_sigma: 0.2,
            heading_sigma: core::f64::consts::PI,
            velocity_sigma: 1.0,
        }
    }
}

/// Disturbances besides the vehicle model, for filters that have one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbances {
    /// Standard deviation of the fast force, each axis (N).
    pub force_sigma: f64,
    /// Standard deviation of the fast yaw moment (N.m).
    pub moment_sigma: f64,
    /// Their correlation time (s).
    pub correlation_time: f64,
    /// White force (N/sqrt(Hz)).
    pub force_density: f64,
    /// White yaw moment (N.m/sqrt(Hz)).
    pub moment_density: f64,
    /// Standard deviation of the slow force: errors of damping and thrust (N).
    pub slow_force_sigma: f64,
    /// Its correlation time (s).
    pub slow_force_time: f64,
    /// Error of thrust-proportional forces (1).
    pub thrust_error: f64,
    /// Standard deviation of the current at the start, each axis (m/s).
    pub current_sigma: f64,
    /// Random walk of the current (m/s/sqrt(s)).
    pub current_walk: f64,
}

impl Default for Disturbances {
    fn default() -> Self {
        Self {
            force_sigma: 20.0,
            moment_sigma: 10.0,
            correlation_time: 5.0,
            force_density: 10.0,
            moment_density: 10.0,
            slow_force_sigma: 5.0,
            slow_force_time: 1000.0,
            thrust_error: 0.1,
            current_sigma: 0.3,
            current_walk: 1e-3,
        }
    }
}

/// Parameters that all navigation filters have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigationParameters {
    /// Longest interval of prediction (s).
    pub interval: f64,
    /// How late a measurement may arrive and still be fused at its own time (s).
    pub latency: f64,
    /// Whether the influence of outliers is limited.
    pub gated: bool,
    /// Errors of the sensors.
    pub sensors: SensorErrors,
    /// Positions of the sensors.
    pub mounting: Mounting,
    /// The start.
    pub start: Start,
    /// Acceleration of gravity (m/s2).
    pub gravity: f64,
    /// White acceleration of a vehicle without inertial unit (m/s2/sqrt(Hz)).
    pub maneuver_acceleration: f64,
    /// White angular rate of a vehicle without gyros (rad/s/sqrt(Hz)).
    pub maneuver_rate: f64,
}

impl Default for NavigationParameters {
    fn default() -> Self {
        Self {
            interval: 0.1,
            latency: 2.5,
            gated: true,
            sensors: SensorErrors::default(),
            mounting: Mounting::default(),
            start: Start::default(),
            gravity: 9.81,
            maneuver_acceleration: 0.2,
            maneuver_rate: 0.2,
        }
    }
}

impl NavigationParameters {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn check(&self) -> Result<(), ParameterError> {
        positive("interval", self.interval)?;
        non_negative("latency", self.latency)?;
        if self.interval > 1.0 {
            let reason = "must be at most 1 s: the motion changes within it";
            return Err(ParameterError::new("interval", self.interval, reason));
        }
        self.sensors.check()?;
        each("mounting.imu", &self.mounting.imu, finite)?;
        each("mounting.dvl", &self.mounting.dvl, finite)?;
        each("mounting.fix", &self.mounting.fix, finite)?;
        each("mounting.pressure", &self.mounting.pressure, finite)?;
        self.start.check()?;
        non_negative("gravity", self.gravity)?;
        positive("maneuver_acceleration", self.maneuver_acceleration)?;
        positive("maneuver_rate", self.maneuver_rate)
    }
}

impl SensorErrors {
    fn check(&self) -> Result<(), ParameterError> {
        self.accelerometer.check("accelerometer")?;
        self.gyro.check("gyro")?;
        positive("tilt_sigma", self.tilt_sigma)?;
        positive("heading_sigma", self.heading_sigma)?;
        non_negative("heading_bias_sigma", self.heading_bias_sigma)?;
        positive("dvl_sigma", self.dvl_sigma)?;
        non_negative("dvl_scale_sigma", self.dvl_scale_sigma)?;
        non_negative("dvl_misalignment_sigma", self.dvl_misalignment_sigma)?;
        non_negative("dvl_delay_sigma", self.dvl_delay_sigma)?;
        positive("fix_sigma", self.fix_sigma)?;
        positive("depth_sigma", self.depth_sigma)
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

impl Start {
    fn check(&self) -> Result<(), ParameterError> {
        each("initial.position", &self.position, finite)?;
        each("initial.attitude", &self.attitude, finite)?;
        each("initial.velocity", &self.velocity, finite)?;
        each("initial.position_sigma", &self.position_sigma, positive)?;
        positive("initial.tilt_sigma", self.tilt_sigma)?;
        positive("initial.heading_sigma", self.heading_sigma)?;
        positive("initial.velocity_sigma", self.velocity_sigma)
    }
}

impl Disturbances {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn check(&self) -> Result<(), ParameterError> {
        non_negative("disturbance.force_sigma", self.force_sigma)?;
        non_negative("disturbance.moment_sigma", self.moment_sigma)?;
        positive("disturbance.correlation_time", self.correlation_time)?;
        positive("disturbance.force_density", self.force_density)?;
        positive("disturbance.moment_density", self.moment_density)?;
        non_negative("disturbance.slow_force_sigma", self.slow_force_sigma)?;
        positive("disturbance.slow_force_time", self.slow_force_time)?;
        non_negative("disturbance.thrust_error", self.thrust_error)?;
        non_negative("disturbance.current_sigma", self.current_sigma)?;
        non_negative("disturbance.current_walk", self.current_walk)
    }
}
