//! Inertial measurement unit: `rexrov::sensors::Imu` with FMI variables.

use crate::groups::{AngularAcceleration, AngularVelocity, Attitude, Vector};
use crate::imu_errors::{Accelerometer, Gyro, ImuGrade};
use crate::instrument::{Instrument, Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{self, ImuMemory, ImuNoise, ImuParameters, ImuTruth};
use serde::{Deserialize, Serialize};

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
