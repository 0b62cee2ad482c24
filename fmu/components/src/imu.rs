//! Inertial measurement unit: `rexrov::sensors::Imu` as a component.

use crate::instrument::{Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{Imu, ImuMemory, ImuParameters, ImuSample, ImuTruth, Instrument};
use serde::{Deserialize, Serialize};

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: ImuTruth,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Force, rate and attitude.
    #[var(flatten)]
    pub sample: ImuSample,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

impl Sensor for Imu {
    const INFO: Info =
        crate::info("Imu", "Specific force, angular rate and attitude with noise and bias");
    type Parameters = ImuParameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = ImuMemory;

    fn preset(selected: &ImuParameters) -> ImuParameters {
        ImuParameters::of(selected.grade)
    }

    fn new(p: &ImuParameters) -> Result<Self, ParameterError> {
        Self::new(p)
    }

    fn instrument(p: &ImuParameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.rate
    }

    fn memory(&self) -> ImuMemory {
        self.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut ImuMemory, u: &Inputs) -> Option<Outputs> {
        let sample = self.sample(memory, &u.vehicle);
        u.switch.is_on().then_some(Outputs { sample, stamp })
    }
}
