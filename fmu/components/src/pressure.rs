//! Pressure sensor: `rexrov::sensors::PressureSensor` as a component.

use crate::instrument::{Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{
    Instrument, PressureMemory, PressureParameters, PressureSample, PressureSensor, PressureTruth,
};
use serde::{Deserialize, Serialize};

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: PressureTruth,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Pressure and depth.
    #[var(flatten)]
    pub sample: PressureSample,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

impl Sensor for PressureSensor {
    const INFO: Info =
        crate::info("PressureSensor", "Absolute pressure and depth with noise and mounting");
    type Parameters = PressureParameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = PressureMemory;

    fn new(p: &PressureParameters) -> Result<Self, ParameterError> {
        Self::new(p)
    }

    fn instrument(p: &PressureParameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.rate
    }

    fn memory(&self) -> PressureMemory {
        self.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut PressureMemory, u: &Inputs) -> Option<Outputs> {
        let sample = self.sample(memory, &u.vehicle);
        u.switch.is_on().then_some(Outputs { sample, stamp })
    }
}
