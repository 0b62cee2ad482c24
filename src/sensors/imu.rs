//! Inertial measurement unit: specific force and turn rate with biases, and orientation.
//!
//! At its position r the specific force is `f + omega' x r + omega x (omega x r)`, with f the
//! specific force at the centre of gravity (Fossen 2011 ch. 11); at rest -9.81 m/s2 on body z. The
//! instruments then measure (Groves 2013 ch. 4.4)
//!
//! ```text
//! accelerometers  (I + M_a) f_b + b + n        gyros  (I + M_g) omega + g f_b + b + n
//! M = [s_x  m_xy m_xz; m_yx s_y  m_yz; m_zx m_zy s_z]      scale errors s, misalignments m
//! ```

use super::Stream;
use super::errors::{BiasMemory, BiasNoise, BiasProcess};
use super::grade::{ImuGrade, ImuNoise};
use super::instrument::Instrument;
use super::noise::Gaussian;
use crate::ParameterError;
use crate::attitude;
use crate::axes;
use crate::error::declared;
use crate::sampling::Rate;
use crate::vector::{Vec3, add, cross, mul, mul_transposed, scale};
use fmu_quantity::{Member, Variables};
use serde::{Deserialize, Serialize};

/// Roll, pitch and yaw of the housing.
const ORIENTATION: [Member; 3] = [
    Member::new("roll", "roll").unit("deg"),
    Member::new("pitch", "pitch").unit("deg"),
    Member::new("yaw", "yaw").unit("deg"),
];

/// Angles by which the axes of an instrument lean towards each other.
const MISALIGNMENT: [Member; 6] = [
    Member::new("xy", "x towards y"),
    Member::new("xz", "x towards z"),
    Member::new("yx", "y towards x"),
    Member::new("yz", "y towards z"),
    Member::new("zx", "z towards x"),
    Member::new("zy", "z towards y"),
];

/// Parameters of an IMU.
#[derive(Clone, Copy, Debug, PartialEq, Variables)]
pub struct ImuParameters {
    /// Grade that gives every figure of noise not set otherwise
    ///
    /// Only [`ImuParameters::of`] uses it.
    pub grade: ImuGrade,
    /// What all sensors have.
    #[var(flatten, start = Instrument::new(50.0, 1))]
    pub instrument: Instrument,
    /// Place in the body frame
    #[var(rename = "mounting", unit = "m", elements = axes::BODY)]
    pub position: [f64; 3],
    /// Orientation of the housing in the body frame
    ///
    /// Specific force and rate are measured along its axes, the attitude is corrected to the body's.
    #[var(elements = ORIENTATION)]
    pub orientation_deg: [f64; 3],
    /// Accelerometers
    #[var(
        unit = "m/s2",
        unit_of(noise_density = "m/(s2.Hz0.5)", random_walk = "m/(s3.Hz0.5)"),
        start = ImuGrade::default().noise().accelerometer
    )]
    pub accelerometer: BiasNoise,
    /// Accelerometers
    ///
    /// The errors of their axes.
    #[var(rename = "accelerometer", unit = "m/s2")]
    pub accelerometer_axes: AxisErrors,
    /// Gyros
    #[var(
        unit = "rad/s",
        unit_of(noise_density = "rad/(s.Hz0.5)", random_walk = "rad/(s2.Hz0.5)"),
        start = ImuGrade::default().noise().gyro
    )]
    pub gyro: BiasNoise,
    /// Gyros
    ///
    /// The errors of their axes.
    #[var(rename = "gyro", unit = "rad/s")]
    pub gyro_axes: AxisErrors,
    /// Gyros: angular rate shown for specific force along the same axis
    #[var(rename = "gyro.g_sensitivity", unit = "rad.s/m", nominal = 1e-5)]
    pub g_sensitivity: f64,
    /// Standard deviation of roll, pitch and compass
    #[var(unit = "rad", min = 0.0, start = ImuGrade::default().noise().attitude_sigma)]
    pub attitude_sigma: f64,
}

/// Constant errors of the three axes of an instrument.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct AxisErrors {
    /// relative error of an axis
    #[var(unit = "1", min = -0.5, max = 0.5, elements = axes::BODY)]
    pub scale_error: [f64; 3],
    /// angle by which one axis leans towards another
    #[var(unit = "rad", min = -0.5, max = 0.5, elements = MISALIGNMENT)]
    pub misalignment: [f64; 6],
    /// largest value shown, of either sign; 0: no limit
    #[var(min = 0.0)]
    pub range: f64,
}

impl AxisErrors {
    /// The reported values for true values along the axes of the housing.
    fn matrix(&self) -> [Vec3; 3] {
        let ([x, y, z], [xy, xz, yx, yz, zx, zy]) = (self.scale_error, self.misalignment);
        [[1.0 + x, xy, xz], [yx, 1.0 + y, yz], [zx, zy, 1.0 + z]]
    }

    fn limited(&self, values: Vec3) -> Vec3 {
        let range = if self.range > 0.0 { self.range } else { f64::INFINITY };
        values.map(|value| value.clamp(-range, range))
    }
}

impl ImuParameters {
    /// The noise of a grade, and no other errors.
    #[must_use]
    pub fn of(grade: ImuGrade) -> Self {
        let ImuNoise { accelerometer, gyro, attitude_sigma } = grade.noise();
        Self { grade, accelerometer, gyro, attitude_sigma, ..Self::default() }
    }
}

/// True motion at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Variables)]
pub struct ImuTruth {
    /// Specific force at the centre of gravity, body frame
    #[var(unit = "m/s2", elements = axes::BODY)]
    pub specific_force: [f64; 3],
    /// Angular velocity, body frame
    #[var(rename = "velocity", elements = axes::ANGULAR_VELOCITY)]
    pub rate: [f64; 3],
    /// Angular acceleration, body frame
    #[var(rename = "acceleration", elements = axes::ANGULAR_ACCELERATION)]
    pub rate_dot: [f64; 3],
    /// Attitude
    #[var(rename = "pose", elements = axes::EULER)]
    pub euler: [f64; 3],
}

/// Outputs of the IMU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Variables)]
pub struct ImuSample {
    /// Specific force at the unit, its axes
    #[var(unit = "m/s2", elements = axes::BODY)]
    pub specific_force: [f64; 3],
    /// Angular velocity, the unit's axes
    #[var(elements = axes::ANGULAR_VELOCITY)]
    pub rate: [f64; 3],
    /// Attitude of the body
    ///
    /// Roll and yaw are in (-pi, pi].
    #[var(rename = "attitude", elements = axes::EULER)]
    pub euler: [f64; 3],
}

/// Noise generators and biases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ImuMemory {
    accelerometer: BiasMemory,
    gyro: BiasMemory,
    attitude: Gaussian,
}

/// An IMU, with its constants derived and checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Imu {
    /// How often it samples.
    pub rate: Rate,
    p: ImuParameters,
    mounting: [Vec3; 3],
    accelerometer: BiasProcess,
    gyro: BiasProcess,
}

impl Imu {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(p: &ImuParameters) -> Result<Self, ParameterError> {
        declared(p)?;
        let rate = p.instrument.rate()?;
        Ok(Self {
            rate,
            p: *p,
            mounting: attitude::rotation_euler(p.orientation_deg.map(f64::to_radians)),
            accelerometer: BiasProcess::new(&p.accelerometer, rate.hz()),
            gyro: BiasProcess::new(&p.gyro, rate.hz()),
        })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> ImuMemory {
        let stream = |stream| self.p.instrument.noise(stream);
        ImuMemory {
            accelerometer: self.accelerometer.memory(stream(Stream::ImuAccelerometer)),
            gyro: self.gyro.memory(stream(Stream::ImuGyro)),
            attitude: stream(Stream::ImuAttitude),
        }
    }

    /// The next sample.
    pub fn sample(&self, memory: &mut ImuMemory, truth: &ImuTruth) -> ImuSample {
        let (omega, r) = (truth.rate, self.p.position);
        let lever = add(cross(truth.rate_dot, r), cross(omega, cross(omega, r)));
        let force = mul_transposed(&self.mounting, add(truth.specific_force, lever));
        let rate = mul_transposed(&self.mounting, omega);
        let (force_axes, rate_axes) = (&self.p.accelerometer_axes, &self.p.gyro_axes);
        let shown_force = add(
            mul(&force_axes.matrix(), force),
            self.accelerometer.sample(&mut memory.accelerometer),
        );
        let shown_rate = add(
            add(mul(&rate_axes.matrix(), rate), scale(force, self.p.g_sensitivity)),
            self.gyro.sample(&mut memory.gyro),
        );
        let tilt = memory.attitude.draw_vector(self.p.attitude_sigma);
        let [roll, pitch, yaw] = add(truth.euler, tilt);
        ImuSample {
            specific_force: force_axes.limited(shown_force),
            rate: rate_axes.limited(shown_rate),
            euler: [attitude::wrap(roll), pitch, attitude::wrap(yaw)],
        }
    }
}
