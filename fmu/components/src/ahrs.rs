//! Attitude and heading reference: `rexrov::sensors::Ahrs` as a component.

use crate::instrument::{Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::axes;
use rexrov::sampling::Rate;
use rexrov::sensors::{Ahrs, AhrsMemory, AhrsParameters, AhrsTruth, Instrument};
use serde::{Deserialize, Serialize};

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion, and the disturbance of the heading.
    #[var(flatten)]
    pub vehicle: AhrsTruth,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Attitude of the body
    #[var(elements = axes::EULER)]
    pub attitude: [f64; 3],
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

impl Sensor for Ahrs {
    const INFO: Info =
        crate::info("Ahrs", "Attitude and heading reference or compass, with its errors");
    type Parameters = AhrsParameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = AhrsMemory;

    fn new(p: &AhrsParameters) -> Result<Self, ParameterError> {
        Self::new(p)
    }

    fn instrument(p: &AhrsParameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.rate
    }

    fn memory(&self) -> AhrsMemory {
        self.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut AhrsMemory, u: &Inputs) -> Option<Outputs> {
        let attitude = self.sample(memory, &u.vehicle);
        u.switch.is_on().then_some(Outputs { attitude, stamp })
    }
}
