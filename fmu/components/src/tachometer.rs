//! Rotor speed sensors: `rexrov::sensors::Tachometer` as a component.

use crate::instrument::{Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{
    Instrument, Tachometer, TachometerMemory, TachometerParameters, TachometerSample,
    TachometerTruth,
};
use serde::{Deserialize, Serialize};

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: TachometerTruth,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Speeds and thrusts.
    #[var(flatten)]
    pub sample: TachometerSample,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

impl Sensor for Tachometer {
    const INFO: Info =
        crate::info("Tachometer", "Rotor speeds of the thrusters and the thrusts they stand for");
    type Parameters = TachometerParameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = TachometerMemory;

    fn new(p: &TachometerParameters) -> Result<Self, ParameterError> {
        Self::new(p)
    }

    fn instrument(p: &TachometerParameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.rate
    }

    fn memory(&self) -> TachometerMemory {
        self.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut TachometerMemory, u: &Inputs) -> Option<Outputs> {
        let sample = self.sample(memory, &u.vehicle);
        u.switch.is_on().then_some(Outputs { sample, stamp })
    }
}
