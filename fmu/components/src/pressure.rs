//! Pressure sensor: `rexrov::sensors::PressureSensor` with FMI variables.

use crate::errors::Outliers;
use crate::groups::{DepthAndTilt, Vector};
use crate::instrument::{Instrument, Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{self, PressureMemory, PressureParameters, PressureTruth};
use serde::{Deserialize, Serialize};

/// Parameters of the pressure sensor.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Place in the body frame
    #[var(unit = "m")]
    pub mounting: Vector,
    /// Standard deviation
    #[var(unit = "Pa", min = 0.0, nominal = 1000.0)]
    pub sigma_pa: f64,
    /// Standard deviation of a constant error, drawn once
    #[var(unit = "Pa", min = 0.0, nominal = 1000.0)]
    pub bias_sigma_pa: f64,
    /// Samples that are far off
    #[var(unit = "Pa")]
    pub outlier: Outliers,
    /// Pressure at the surface
    #[var(unit = "Pa", min = 0.0, nominal = 1e5)]
    pub surface_pressure_pa: f64,
    /// Increase of pressure with depth
    #[var(unit = "Pa/m", min = 1.0, nominal = 1e4)]
    pub gradient_pa_per_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = PressureParameters::default();
        Self {
            instrument: Instrument::new(p.rate_hz, p.seed),
            mounting: p.position.into(),
            sigma_pa: p.sigma_pa,
            bias_sigma_pa: p.bias_sigma_pa,
            outlier: p.outlier.into(),
            surface_pressure_pa: p.surface_pressure_pa,
            gradient_pa_per_m: p.gradient_pa_per_m,
        }
    }
}

/// True motion.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Vehicle {
    /// Pose of the centre of gravity
    pub pose: DepthAndTilt,
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
    /// Absolute pressure at the sensor
    #[var(unit = "Pa", nominal = 1e5)]
    pub pressure: f64,
    /// Depth of the sensor that this pressure stands for
    #[var(unit = "m")]
    pub depth: f64,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// The pressure sensor.
pub struct PressureSensor(sensors::PressureSensor);

impl Sensor for PressureSensor {
    const INFO: Info =
        crate::info("PressureSensor", "Absolute pressure and depth with noise and mounting");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = PressureMemory;

    fn new(p: &Parameters) -> Result<Self, ParameterError> {
        let parameters = PressureParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            position: p.mounting.into(),
            sigma_pa: p.sigma_pa,
            bias_sigma_pa: p.bias_sigma_pa,
            outlier: p.outlier.into(),
            surface_pressure_pa: p.surface_pressure_pa,
            gradient_pa_per_m: p.gradient_pa_per_m,
        };
        sensors::PressureSensor::new(&parameters).map(Self)
    }

    fn instrument(p: &Parameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.0.rate
    }

    fn memory(&self) -> PressureMemory {
        self.0.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut PressureMemory, u: &Inputs) -> Option<Outputs> {
        let DepthAndTilt { z, roll, pitch } = u.vehicle.pose;
        let sample = self.0.sample(memory, &PressureTruth { z, euler: [roll, pitch, 0.0] });
        let shown = Outputs { pressure: sample.pressure_pa, depth: sample.depth, stamp };
        u.switch.is_on().then_some(shown)
    }
}
