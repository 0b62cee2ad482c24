//! Grades of inertial measurement units, shared by sensors and filters.

use super::BiasNoise;
use fmu_quantity::Enumeration;

/// Grades of inertial measurement units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
pub enum ImuGrade {
    /// Analog Devices ADIS16448 (MEMS), with the values of UUV Simulator
    #[default]
    Adis16448,
    /// a good MEMS unit, calibrated over temperature
    Industrial,
    /// fibre-optic or ring-laser gyros, quartz accelerometers
    Tactical,
}

/// Random errors of an inertial measurement unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuNoise {
    /// Errors of the accelerometers (m/s2).
    pub accelerometer: BiasNoise,
    /// Errors of the gyros (rad/s).
    pub gyro: BiasNoise,
    /// Standard deviation of roll, pitch and heading (rad).
    pub attitude_sigma: f64,
}

impl ImuGrade {
    /// Random errors typical of the grade.
    #[must_use]
    pub fn noise(self) -> ImuNoise {
        // Density, random walk, turn-on bias.
        let (accelerometer, gyro, attitude_sigma) = match self {
            Self::Adis16448 => ([0.004, 0.006, 0.196], [3.394e-4, 3.88e-5, 0.0087], 0.01),
            Self::Industrial => ([1e-3, 2.5e-4, 0.03], [1e-4, 5e-6, 1e-3], 0.003),
            Self::Tactical => ([5e-4, 2e-5, 0.005], [3e-5, 1e-6, 2e-5], 0.0005),
        };
        let noise = |[noise_density, random_walk, turn_on_sigma]: [f64; 3], correlation_time| {
            BiasNoise { noise_density, random_walk, correlation_time, turn_on_sigma }
        };
        ImuNoise {
            accelerometer: noise(accelerometer, 300.0),
            gyro: noise(gyro, 1000.0),
            attitude_sigma,
        }
    }
}
