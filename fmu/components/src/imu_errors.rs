//! Errors of inertial instruments as FMI parameters, and the grades that set them.

use crate::errors::{AccelerometerNoise, GyroNoise};
use crate::groups::Vector;
use fmu_kit::{Enumeration, Variables};
use rexrov::sensors::{self, AxisErrors, BiasNoise};

/// Grades of inertial measurement units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Enumeration)]
pub enum ImuGrade {
    /// Analog Devices ADIS16448 (MEMS), with the values of UUV Simulator
    #[default]
    Adis16448,
    /// a good MEMS unit, calibrated over temperature
    Industrial,
    /// fibre-optic or ring-laser gyros, quartz accelerometers
    Tactical,
}

impl From<ImuGrade> for sensors::ImuGrade {
    fn from(grade: ImuGrade) -> Self {
        match grade {
            ImuGrade::Adis16448 => Self::Adis16448,
            ImuGrade::Industrial => Self::Industrial,
            ImuGrade::Tactical => Self::Tactical,
        }
    }
}

crate::groups::group! {
    /// Angles by which the axes of an instrument lean towards each other.
    Misalignment = [
        /// x towards y
        xy,
        /// x towards z
        xz,
        /// y towards x
        yx,
        /// y towards z
        yz,
        /// z towards x
        zx,
        /// z towards y
        zy; 6]
}

/// Errors of the accelerometers.
#[derive(Clone, Debug, Variables)]
pub struct Accelerometer {
    /// Noise.
    #[var(flatten)]
    pub noise: AccelerometerNoise,
    /// relative error of an axis
    #[var(unit = "1", min = -0.5, max = 0.5)]
    pub scale_error: Vector,
    /// angle by which one axis leans towards another
    #[var(unit = "rad", min = -0.5, max = 0.5)]
    pub misalignment: Misalignment,
    /// largest value shown, of either sign; 0: no limit
    #[var(unit = "m/s2", min = 0.0)]
    pub range: f64,
}

/// Errors of the gyros.
#[derive(Clone, Debug, Variables)]
pub struct Gyro {
    /// Noise.
    #[var(flatten)]
    pub noise: GyroNoise,
    /// relative error of an axis
    #[var(unit = "1", min = -0.5, max = 0.5)]
    pub scale_error: Vector,
    /// angle by which one axis leans towards another
    #[var(unit = "rad", min = -0.5, max = 0.5)]
    pub misalignment: Misalignment,
    /// largest value shown, of either sign; 0: no limit
    #[var(unit = "rad/s", min = 0.0)]
    pub range: f64,
    /// angular rate shown for specific force along the same axis
    #[var(unit = "rad.s/m", nominal = 1e-5)]
    pub g_sensitivity: f64,
}

/// Both instruments have the same kinds of error, in different units.
macro_rules! errors {
    ($($instrument:ident { $($own:ident)? }),+) => {$(
        impl From<BiasNoise> for $instrument {
            fn from(b: BiasNoise) -> Self {
                Self {
                    noise: b.into(),
                    scale_error: Vector::default(),
                    misalignment: Misalignment::default(),
                    range: 0.0,
                    $($own: 0.0,)?
                }
            }
        }

        impl From<&$instrument> for AxisErrors {
            fn from(i: &$instrument) -> Self {
                Self {
                    scale_error: i.scale_error.into(),
                    misalignment: i.misalignment.into(),
                    range: i.range,
                }
            }
        }
    )+};
}

errors!(Accelerometer {}, Gyro { g_sensitivity });
