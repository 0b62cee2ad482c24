//! Inertial measurement unit: `rexrov::sensors::Imu` with FMI variables.

use crate::groups::{AngularAcceleration, AngularVelocity, Attitude, Vector, parameter_error};
use crate::instrument::{Instrument, Stamp, Switch};
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::sensors::{self, BiasNoise, ImuMemory, ImuParameters, ImuTruth};
use serde::{Deserialize, Serialize};

/// Errors of the accelerometers.
#[derive(Clone, Debug, Variables)]
pub struct Accelerometer {
    /// density of the white noise
    #[var(unit = "m/(s2.Hz0.5)", min = 0.0)]
    pub noise_density: f64,
    /// density of the noise that drives the slow bias
    #[var(unit = "m/(s3.Hz0.5)", min = 0.0)]
    pub random_walk: f64,
    /// correlation time of the slow bias
    #[var(unit = "s", min = 0.0)]
    pub correlation_time: f64,
    /// standard deviation of the bias after switching on
    #[var(unit = "m/s2", min = 0.0)]
    pub turn_on_sigma: f64,
}

/// Errors of the gyros.
#[derive(Clone, Debug, Variables)]
pub struct Gyro {
    /// density of the white noise
    #[var(unit = "rad/(s.Hz0.5)", min = 0.0)]
    pub noise_density: f64,
    /// density of the noise that drives the slow bias
    #[var(unit = "rad/(s2.Hz0.5)", min = 0.0)]
    pub random_walk: f64,
    /// correlation time of the slow bias
    #[var(unit = "s", min = 0.0)]
    pub correlation_time: f64,
    /// standard deviation of the bias after switching on
    #[var(unit = "rad/s", min = 0.0)]
    pub turn_on_sigma: f64,
}

/// Both instruments have the same kinds of error, in other units.
macro_rules! bias_noise {
    ($($instrument:ident),+) => {$(
        impl From<BiasNoise> for $instrument {
            fn from(b: BiasNoise) -> Self {
                Self {
                    noise_density: b.noise_density,
                    random_walk: b.random_walk,
                    correlation_time: b.correlation_time,
                    turn_on_sigma: b.turn_on_sigma,
                }
            }
        }

        impl From<&$instrument> for BiasNoise {
            fn from(i: &$instrument) -> Self {
                Self {
                    noise_density: i.noise_density,
                    random_walk: i.random_walk,
                    correlation_time: i.correlation_time,
                    turn_on_sigma: i.turn_on_sigma,
                }
            }
        }
    )+};
}

bias_noise!(Accelerometer, Gyro);

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
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
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

impl Default for Parameters {
    fn default() -> Self {
        let p = ImuParameters::default();
        let [roll, pitch, yaw] = p.orientation_deg;
        Self {
            instrument: Instrument::new(p.rate_hz, p.seed, p.position),
            orientation_deg: Orientation { roll, pitch, yaw },
            accelerometer: p.accelerometer.into(),
            gyro: p.gyro.into(),
            attitude_sigma: p.attitude_sigma,
        }
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

impl Sample for Imu {
    const INFO: Info =
        crate::info("Imu", "Specific force, angular rate and attitude with noise and bias");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = ImuMemory;

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let Orientation { roll, pitch, yaw } = p.orientation_deg;
        let parameters = ImuParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            position: p.instrument.mounting.into(),
            orientation_deg: [roll, pitch, yaw],
            accelerometer: (&p.accelerometer).into(),
            gyro: (&p.gyro).into(),
            attitude_sigma: p.attitude_sigma,
        };
        sensors::Imu::new(&parameters).map(Self).map_err(parameter_error)
    }

    fn period_s(&self) -> f64 {
        self.0.rate.period()
    }

    fn memory(&self) -> ImuMemory {
        self.0.memory()
    }

    fn sample(
        &self,
        now: Time,
        memory: &mut ImuMemory,
        u: &Inputs,
        y: &mut Outputs,
    ) -> Result<(), Fault> {
        let truth = ImuTruth {
            specific_force: u.vehicle.specific_force.into(),
            rate: u.vehicle.velocity.into(),
            rate_dot: u.vehicle.acceleration.into(),
            euler: u.vehicle.pose.into(),
        };
        let sample = self.0.sample(memory, &truth);
        if u.switch.is_on() {
            *y = Outputs {
                specific_force: sample.specific_force.into(),
                rate: sample.rate.into(),
                attitude: sample.euler.into(),
                stamp: Stamp::at(now),
            };
        }
        Ok(())
    }
}
