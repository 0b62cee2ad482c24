//! Inertial measurement unit: specific force and turn rate with biases, and orientation.
//!
//! At its place r the specific force is `f + omega' x r + omega x (omega x r)`, f the one at the
//! centre of gravity (Fossen 2011 ch. 11); at rest -9.81 m/s2 on body z. Nominal: ADIS16448.

use super::noise::{BiasMemory, BiasNoise, BiasProcess, Gaussian};
use crate::ParameterError;
use crate::attitude;
use crate::error::{each, finite, non_negative};
use crate::sampling::Rate;
use crate::vector::{Vec3, add, cross, mul_transposed};
use serde::{Deserialize, Serialize};

/// Parameters of an IMU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuParameters {
    /// Samples a second (Hz).
    pub rate_hz: f64,
    /// Seed of all its noise.
    pub seed: u64,
    /// Place, body (m).
    pub position: [f64; 3],
    /// Roll, pitch and yaw of the housing in the body frame (deg); specific force and rate are
    /// measured along its axes, the orientation output is corrected to the body's.
    pub orientation_deg: [f64; 3],
    /// Errors of the accelerometers (m/s2).
    pub accelerometer: BiasNoise,
    /// Errors of the gyros (rad/s).
    pub gyro: BiasNoise,
    /// Standard deviation of roll, pitch and compass (rad).
    pub attitude_sigma: f64,
}

impl Default for ImuParameters {
    fn default() -> Self {
        Self {
            rate_hz: 50.0,
            seed: 1,
            position: [0.0; 3],
            orientation_deg: [0.0; 3],
            accelerometer: BiasNoise {
                noise_density: 0.004,
                random_walk: 0.006,
                correlation_time: 300.0,
                turn_on_sigma: 0.196,
            },
            gyro: BiasNoise {
                noise_density: 3.394e-4,
                random_walk: 3.88e-5,
                correlation_time: 1000.0,
                turn_on_sigma: 0.0087,
            },
            attitude_sigma: 0.01,
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

/// What the IMU shows.
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

/// An IMU, its constants derived and checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Imu {
    /// How often it samples.
    pub rate: Rate,
    seed: u64,
    position: Vec3,
    mounting: [Vec3; 3],
    accelerometer: BiasProcess,
    gyro: BiasProcess,
    attitude_sigma: f64,
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
        non_negative("attitude_sigma", p.attitude_sigma)?;
        Ok(Self {
            rate,
            seed: p.seed,
            position: p.position,
            mounting: attitude::rotation_euler(p.orientation_deg.map(f64::to_radians)),
            accelerometer: BiasProcess::new(&p.accelerometer, p.rate_hz),
            gyro: BiasProcess::new(&p.gyro, p.rate_hz),
            attitude_sigma: p.attitude_sigma,
        })
    }

    /// The memory at switch-on.
    #[must_use]
    pub fn memory(&self) -> ImuMemory {
        ImuMemory {
            accelerometer: self.accelerometer.memory(self.seed, 0),
            gyro: self.gyro.memory(self.seed, 1),
            attitude: Gaussian::new(self.seed, 2),
        }
    }

    /// The next sample.
    pub fn sample(&self, memory: &mut ImuMemory, truth: &ImuTruth) -> ImuSample {
        let omega = truth.rate;
        let lever =
            add(cross(truth.rate_dot, self.position), cross(omega, cross(omega, self.position)));
        let force = mul_transposed(&self.mounting, add(truth.specific_force, lever));
        let rate = mul_transposed(&self.mounting, omega);
        let tilt = memory.attitude.draw_vector(self.attitude_sigma);
        let [roll, pitch, yaw] = add(truth.euler, tilt);
        ImuSample {
            specific_force: add(force, self.accelerometer.sample(&mut memory.accelerometer)),
            rate: add(rate, self.gyro.sample(&mut memory.gyro)),
            euler: [attitude::wrap(roll), pitch, attitude::wrap(yaw)],
        }
    }
}
