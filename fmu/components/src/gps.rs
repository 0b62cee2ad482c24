//! Horizontal position fix (the paper's GPS): `rexrov::sensors::Gps` as a component.

use crate::instrument::{Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{Gps, GpsFix, GpsMemory, GpsParameters, GpsTruth, Instrument};
use serde::{Deserialize, Serialize};

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: GpsTruth,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// The fix.
    #[var(flatten)]
    pub fix: GpsFix,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

impl Sensor for Gps {
    const INFO: Info =
        crate::info("Gps", "Horizontal position fix (GPS, USBL, LBL) with noise and lever arm");
    type Parameters = GpsParameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = GpsMemory;

    fn new(p: &GpsParameters) -> Result<Self, ParameterError> {
        Self::new(p)
    }

    fn instrument(p: &GpsParameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.rate
    }

    fn memory(&self) -> GpsMemory {
        self.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut GpsMemory, u: &Inputs) -> Option<Outputs> {
        let fix = self.sample(memory, &u.vehicle).filter(|_| u.switch.is_on())?;
        Some(Outputs { fix, stamp })
    }
}
