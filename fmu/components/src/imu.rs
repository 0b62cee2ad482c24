//! Inertial measurement unit: `rexrov::sensors::Imu` with FMI variables.

use crate::errors::{AccelerometerNoise, GyroNoise};
use crate::groups::{AngularAcceleration, AngularVelocity, Attitude, Vector};
use crate::imu_errors::{Accelerometer, Gyro, ImuGrade};
use crate::instrument::{Instrument, Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{self, ImuMemory, ImuNoise, ImuParameters, ImuTruth};
use serde::{Deserialize, Serialize};

<<<<<<< HEAD
=======
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

/// Both instruments have the same kinds of error, in other units.
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

>>>>>>> wt-components
/// Roll, pitch and yaw of the housing.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Orientation {
    /// roll
    #[var(unit = "deg")]
    pub roll: f64,
    /// pitch
    #[var(unit = "deg")]
    pub pitch: f64,
    /// yaw
    #[var(unit = "deg")]
    pub yaw: f64,
}

/// Parameters of the inertial measurement unit.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// Grade that gives every figure of noise not set otherwise
    pub grade: ImuGrade,
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Place in the body frame
    #[var(unit = "m")]
    pub mounting: Vector,
    /// Orientation of the housing in the body frame
    pub orientation_deg: Orientation,
    /// Accelerometers
    pub accelerometer: Accelerometer,
    /// Gyros
    pub gyro: Gyro,
    /// Standard deviation of roll, pitch and compass
    #[var(unit = "rad", min = 0.0)]
    pub attitude_sigma: f64,
}

impl Parameters {
    /// The noise of a grade, and no other errors.
    fn of(grade: ImuGrade) -> Self {
        let p = ImuParameters::default();
        let ImuNoise { accelerometer, gyro, attitude_sigma } =
            sensors::ImuGrade::from(grade).noise();
        let [roll, pitch, yaw] = p.orientation_deg;
        Self {
            grade,
            instrument: Instrument::new(p.rate_hz, p.seed),
            mounting: p.position.into(),
            orientation_deg: Orientation { roll, pitch, yaw },
            accelerometer: accelerometer.into(),
            gyro: gyro.into(),
            attitude_sigma,
        }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::of(ImuGrade::default())
    }
}

/// True motion.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Vehicle {
    /// Specific force at the centre of gravity, body frame
    #[var(unit = "m/s2")]
    pub specific_force: Vector,
    /// Angular velocity, body frame
    pub velocity: AngularVelocity,
    /// Angular acceleration, body frame
    pub acceleration: AngularAcceleration,
    /// Attitude
    pub pose: Attitude,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: Vehicle,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Specific force at the unit, its axes
    #[var(unit = "m/s2")]
    pub specific_force: Vector,
    /// Angular velocity, the unit's axes
    pub rate: AngularVelocity,
    /// Attitude of the body
    pub attitude: Attitude,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// The inertial measurement unit.
pub struct Imu(sensors::Imu);

impl Sensor for Imu {
    const INFO: Info =
        crate::info("Imu", "Specific force, angular rate and attitude with noise and bias");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = ImuMemory;

    fn preset(selected: &Parameters) -> Parameters {
        Parameters::of(selected.grade)
    }

    fn new(p: &Parameters) -> Result<Self, ParameterError> {
        let Orientation { roll, pitch, yaw } = p.orientation_deg;
        let parameters = ImuParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            position: p.mounting.into(),
            orientation_deg: [roll, pitch, yaw],
            accelerometer: p.accelerometer.noise.into(),
            gyro: p.gyro.noise.into(),
            accelerometer_axes: (&p.accelerometer).into(),
            gyro_axes: (&p.gyro).into(),
            g_sensitivity: p.gyro.g_sensitivity,
            attitude_sigma: p.attitude_sigma,
        };
        sensors::Imu::new(&parameters).map(Self)
    }

    fn instrument(p: &Parameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.0.rate
    }

    fn memory(&self) -> ImuMemory {
        self.0.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut ImuMemory, u: &Inputs) -> Option<Outputs> {
        let truth = ImuTruth {
            specific_force: u.vehicle.specific_force.into(),
            rate: u.vehicle.velocity.into(),
            rate_dot: u.vehicle.acceleration.into(),
            euler: u.vehicle.pose.into(),
        };
        let sample = self.0.sample(memory, &truth);
        u.switch.is_on().then(|| Outputs {
            specific_force: sample.specific_force.into(),
            rate: sample.rate.into(),
            attitude: sample.euler.into(),
            stamp,
        })
    }
}
