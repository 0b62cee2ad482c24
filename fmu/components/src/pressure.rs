//! Pressure sensor: `rexrov::sensors::PressureSensor` with FMI variables.

use crate::groups::parameter_error;
use crate::instrument::{Instrument, Stamp, Switch};
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::sensors::{self, PressureMemory, PressureParameters, PressureTruth};
use serde::{Deserialize, Serialize};

/// Parameters of the pressure sensor.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Standard deviation
    #[var(unit = "Pa", min = 0.0, nominal = 1000.0)]
    pub sigma_pa: f64,
    /// Pressure at the surface
    #[var(unit = "Pa", min = 0.0, nominal = 1e5)]
    pub surface_pressure_pa: f64,
    /// Increase of pressure with depth
    #[var(unit = "Pa/m", min = 0.0, nominal = 1e4)]
    pub gradient_pa_per_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = PressureParameters::default();
        Self {
            instrument: Instrument::new(p.rate_hz, p.seed, p.position),
            sigma_pa: p.sigma_pa,
            surface_pressure_pa: p.surface_pressure_pa,
            gradient_pa_per_m: p.gradient_pa_per_m,
        }
    }
}

/// What matters of the true pose.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Pose {
    /// down
    #[var(unit = "m")]
    pub z: f64,
    /// roll
    #[var(unit = "rad")]
    pub roll: f64,
    /// pitch
    #[var(unit = "rad")]
    pub pitch: f64,
}

/// True motion.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Vehicle {
    /// Pose of the centre of gravity
    pub pose: Pose,
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

impl Sample for PressureSensor {
    const INFO: Info =
        crate::info("PressureSensor", "Absolute pressure and depth with noise and mounting");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = PressureMemory;

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let parameters = PressureParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            position: p.instrument.mounting.into(),
            sigma_pa: p.sigma_pa,
            surface_pressure_pa: p.surface_pressure_pa,
            gradient_pa_per_m: p.gradient_pa_per_m,
        };
        sensors::PressureSensor::new(&parameters).map(Self).map_err(parameter_error)
    }

    fn period_s(&self) -> f64 {
        self.0.rate.period()
    }

    fn memory(&self) -> PressureMemory {
        self.0.memory()
    }

    fn sample(
        &self,
        now: Time,
        memory: &mut PressureMemory,
        u: &Inputs,
        y: &mut Outputs,
    ) -> Result<(), Fault> {
        let Pose { z, roll, pitch } = u.vehicle.pose;
        let sample = self.0.sample(memory, &PressureTruth { z, euler: [roll, pitch, 0.0] });
        if u.switch.is_on() {
            *y = Outputs {
                pressure: sample.pressure_pa,
                depth: sample.depth,
                stamp: Stamp::at(now),
            };
        }
        Ok(())
    }
}
