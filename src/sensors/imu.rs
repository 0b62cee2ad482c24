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

use super::errors::{BiasMemory, BiasNoise, BiasProcess};
use super::grade::ImuGrade;
use super::noise::{Gaussian, Stream};
use crate::ParameterError;
use crate::attitude;
use crate::error::{each, finite, non_negative, within};
use crate::sampling::Rate;
use crate::vector::{Vec3, add, cross, mul, mul_transposed, scale};
use serde::{Deserialize, Serialize};

/// Parameters of an IMU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of all its noise.
    pub seed: u64,
    /// Position, body (m).
    pub position: [f64; 3],
    /// Roll, pitch and yaw of the housing in the body frame (deg); specific force and rate are
    /// measured along its axes, the orientation output is corrected to the body's.
    pub orientation_deg: [f64; 3],
    /// Errors of the accelerometers (m/s2).
    pub accelerometer: BiasNoise,
    /// Errors of the gyros (rad/s).
    pub gyro: BiasNoise,
    /// Errors of the axes of the accelerometers, range in m/s2.
    pub accelerometer_axes: AxisErrors,
    /// Errors of the axes of the gyros, range in rad/s.
    pub gyro_axes: AxisErrors,
    /// Turn rate that a gyro reports for specific force along its axis (rad/s per m/s2).
    pub g_sensitivity: f64,
    /// Standard deviation of roll, pitch and compass (rad).
    pub attitude_sigma: f64,
}

/// Constant errors of the three axes of an instrument.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisErrors {
    /// Relative error of each axis.
    pub scale_error: [f64; 3],
    /// Small angles by which one axis is inclined towards another (rad): x towards y, x towards z,
    /// y towards x, y towards z, z towards x, z towards y.
    pub misalignment: [f64; 6],
    /// Largest value reported, of either sign; 0: no limit.
    pub range: f64,
}

impl AxisErrors {
    fn check(&self, name: &str) -> Result<(), ParameterError> {
        let small = |name: &str, value| within(name, value, -0.5, 0.5);
        each(&format!("{name}.scale_error"), &self.scale_error, small)?;
        each(&format!("{name}.misalignment"), &self.misalignment, small)?;
        non_negative(&format!("{name}.range"), self.range)
    }

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

impl Default for ImuParameters {
    fn default() -> Self {
        let noise = ImuGrade::default().noise();
        Self {
            rate_hz: 50.0,
            seed: 1,
            position: [0.0; 3],
            orientation_deg: [0.0; 3],
            accelerometer: noise.accelerometer,
            gyro: noise.gyro,
            accelerometer_axes: AxisErrors::default(),
            gyro_axes: AxisErrors::default(),
            g_sensitivity: 0.0,
            attitude_sigma: noise.attitude_sigma,
        }
    }
}

/// True motion at a sample instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuTruth {
    /// Specific force at the centre of gravity, body (m/s2).
    pub specific_force: [f64; 3],
    /// Turn rate `[p, q, r]` (rad/s).
    pub rate: [f64; 3],
    /// Its time derivative (rad/s2).
    pub rate_dot: [f64; 3],
    /// Roll, pitch, yaw (rad).
    pub euler: [f64; 3],
}

/// Outputs of the IMU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ImuSample {
    /// Specific force at the IMU, its axes (m/s2).
    pub specific_force: [f64; 3],
    /// Turn rate, its axes (rad/s).
    pub rate: [f64; 3],
    /// Roll, pitch, yaw of the body (rad), roll and yaw in (-pi, pi].
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
        let rate = Rate::new(p.rate_hz)?;
        each("position", &p.position, finite)?;
        each("orientation_deg", &p.orientation_deg, finite)?;
        p.accelerometer.check("accelerometer")?;
        p.gyro.check("gyro")?;
        p.accelerometer_axes.check("accelerometer")?;
        p.gyro_axes.check("gyro")?;
        finite("gyro.g_sensitivity", p.g_sensitivity)?;
        non_negative("attitude_sigma", p.attitude_sigma)?;
        Ok(Self {
            rate,
            p: *p,
            mounting: attitude::rotation_euler(p.orientation_deg.map(f64::to_radians)),
            accelerometer: BiasProcess::new(&p.accelerometer, p.rate_hz),
            gyro: BiasProcess::new(&p.gyro, p.rate_hz),
        })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> ImuMemory {
        ImuMemory {
            accelerometer: self.accelerometer.memory(self.p.seed, Stream::ImuAccelerometer),
            gyro: self.gyro.memory(self.p.seed, Stream::ImuGyro),
            attitude: Gaussian::new(self.p.seed, Stream::ImuAttitude),
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
