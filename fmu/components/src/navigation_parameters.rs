//! Parameters that all navigation filters but the paper's have:
//! `rexrov::estimation::NavigationParameters` as FMI variables.

use crate::errors::{AccelerometerNoise, GyroNoise};
use crate::groups::{LinearVelocity, Pose, Vector};
use crate::imu_errors::ImuGrade;
use fmu_kit::Variables;
use rexrov::estimation::{self, NavigationParameters, SensorErrors};
use rexrov::sensors::{self, ImuNoise};

/// Positions of the sensors, body frame.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Mounting {
    /// inertial unit
    #[var(unit = "m")]
    pub imu: Vector,
    /// velocity log
    #[var(unit = "m")]
    pub dvl: Vector,
    /// antenna or transponder of the fix
    #[var(unit = "m")]
    pub fix: Vector,
    /// pressure sensor
    #[var(unit = "m")]
    pub pressure: Vector,
}

/// Standard deviations at the start.
#[derive(Clone, Copy, Debug, Variables)]
pub struct StartSigma {
    /// north
    #[var(unit = "m", min = 1e-6)]
    pub x: f64,
    /// east
    #[var(unit = "m", min = 1e-6)]
    pub y: f64,
    /// down
    #[var(unit = "m", min = 1e-6)]
    pub z: f64,
    /// roll and pitch
    #[var(unit = "rad", min = 1e-6)]
    pub tilt: f64,
    /// yaw; from 0.5 on the first heading measured becomes the estimate
    #[var(unit = "rad", min = 1e-6)]
    pub yaw: f64,
    /// velocity, each axis
    #[var(unit = "m/s", min = 1e-6)]
    pub velocity: f64,
}

/// Assumptions at the start.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Start {
    /// pose
    pub pose: Pose,
    /// velocity over ground, body frame
    pub velocity: LinearVelocity,
    /// standard deviation
    pub sigma: StartSigma,
}

/// How a vehicle without inertial unit manoeuvres.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Maneuver {
    /// density of its white acceleration
    #[var(unit = "m/(s2.Hz0.5)", min = 1e-9)]
    pub acceleration: f64,
    /// density of its white angular rate
    #[var(unit = "rad/(s.Hz0.5)", min = 1e-9)]
    pub rate: f64,
}

/// Parameters of a navigation filter.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Parameters {
    /// How often the inputs are looked at and the outputs renewed
    #[var(unit = "Hz", min = 1.0, max = 1e6)]
    pub rate_hz: f64,
    /// Longest interval of prediction
    #[var(unit = "s", min = 0.01, max = 1.0)]
    pub prediction_interval: f64,
    /// How late a measurement may come and still be put in its place
    #[var(unit = "s", min = 0.0, max = 3600.0)]
    pub latency: f64,
    /// Whether the influence of outliers is limited
    pub outlier_limit: bool,
    /// Grade that gives accelerometer, gyro and tilt_sigma where they are not set
    pub imu_grade: ImuGrade,
    /// Accelerometers
    pub accelerometer: AccelerometerNoise,
    /// Gyros
    pub gyro: GyroNoise,
    /// Standard deviation of roll and pitch of the attitude reference
    #[var(unit = "rad", min = 1e-9)]
    pub tilt_sigma: f64,
    /// Standard deviation of its heading
    #[var(unit = "rad", min = 1e-9)]
    pub heading_sigma: f64,
    /// Standard deviation of the constant error of the heading; 0: none, not estimated
    #[var(unit = "rad", min = 0.0)]
    pub heading_bias_sigma: f64,
    /// Standard deviation of the velocity log, each axis
    #[var(unit = "m/s", min = 1e-9)]
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
    #[var(unit = "m", min = 1e-9)]
    pub fix_sigma: f64,
    /// Standard deviation of the depth
    #[var(unit = "m", min = 1e-9)]
    pub depth_sigma: f64,
    /// Place in the body frame
    pub mounting: Mounting,
    /// Start
    pub initial: Start,
    /// Acceleration of gravity
    #[var(unit = "m/s2", min = 0.0)]
    pub gravity: f64,
    /// Manoeuvres while the inertial unit is silent
    pub maneuver: Maneuver,
}

impl From<estimation::Mounting> for Mounting {
    fn from(m: estimation::Mounting) -> Self {
        let estimation::Mounting { imu, dvl, fix, pressure } = m;
        Self { imu: imu.into(), dvl: dvl.into(), fix: fix.into(), pressure: pressure.into() }
    }
}

impl From<Mounting> for estimation::Mounting {
    fn from(m: Mounting) -> Self {
        let Mounting { imu, dvl, fix, pressure } = m;
        Self { imu: imu.into(), dvl: dvl.into(), fix: fix.into(), pressure: pressure.into() }
    }
}

impl From<estimation::Start> for Start {
    fn from(s: estimation::Start) -> Self {
        let ([x, y, z], [roll, pitch, yaw]) = (s.position, s.attitude);
        let pose = [x, y, z, roll, pitch, yaw].into();
        let [x, y, z] = s.position_sigma;
        let (tilt, yaw, velocity) = (s.tilt_sigma, s.heading_sigma, s.velocity_sigma);
        let sigma = StartSigma { x, y, z, tilt, yaw, velocity };
        Self { pose, velocity: s.velocity.into(), sigma }
    }
}

impl From<Start> for estimation::Start {
    fn from(s: Start) -> Self {
        let Pose { x, y, z, roll, pitch, yaw } = s.pose;
        Self {
            position: [x, y, z],
            attitude: [roll, pitch, yaw],
            velocity: s.velocity.into(),
            position_sigma: [s.sigma.x, s.sigma.y, s.sigma.z],
            tilt_sigma: s.sigma.tilt,
            heading_sigma: s.sigma.yaw,
            velocity_sigma: s.sigma.velocity,
        }
    }
}

impl Parameters {
    /// The values of a grade.
    pub fn of(imu_grade: ImuGrade) -> Self {
        let p = NavigationParameters::default();
        let s = p.sensors;
        let ImuNoise { accelerometer, gyro, attitude_sigma } =
            sensors::ImuGrade::from(imu_grade).noise();
        Self {
            rate_hz: 100.0,
            prediction_interval: p.interval,
            latency: p.latency,
            outlier_limit: p.gated,
            imu_grade,
            accelerometer: accelerometer.into(),
            gyro: gyro.into(),
            tilt_sigma: attitude_sigma,
            heading_sigma: s.heading_sigma,
            heading_bias_sigma: s.heading_bias_sigma,
            dvl_sigma: s.dvl_sigma,
            dvl_scale_sigma: s.dvl_scale_sigma,
            dvl_misalignment_sigma: s.dvl_misalignment_sigma,
            dvl_delay_sigma: s.dvl_delay_sigma,
            fix_sigma: s.fix_sigma,
            depth_sigma: s.depth_sigma,
            mounting: p.mounting.into(),
            initial: p.start.into(),
            gravity: p.gravity,
            maneuver: Maneuver { acceleration: p.maneuver_acceleration, rate: p.maneuver_rate },
        }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::of(ImuGrade::default())
    }
}

impl From<&Parameters> for NavigationParameters {
    fn from(p: &Parameters) -> Self {
        Self {
            interval: p.prediction_interval,
            latency: p.latency,
            gated: p.outlier_limit,
            sensors: SensorErrors {
                accelerometer: p.accelerometer.into(),
                gyro: p.gyro.into(),
                tilt_sigma: p.tilt_sigma,
                heading_sigma: p.heading_sigma,
                heading_bias_sigma: p.heading_bias_sigma,
                dvl_sigma: p.dvl_sigma,
                dvl_scale_sigma: p.dvl_scale_sigma,
                dvl_misalignment_sigma: p.dvl_misalignment_sigma,
                dvl_delay_sigma: p.dvl_delay_sigma,
                fix_sigma: p.fix_sigma,
                depth_sigma: p.depth_sigma,
            },
            mounting: p.mounting.into(),
            start: p.initial.into(),
            gravity: p.gravity,
            maneuver_acceleration: p.maneuver.acceleration,
            maneuver_rate: p.maneuver.rate,
        }
    }
}
