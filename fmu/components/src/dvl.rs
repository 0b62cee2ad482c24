//! Doppler velocity log: `rexrov::sensors::Dvl` as a component.

use crate::instrument::{Stamp, Switch};
use crate::sensing::Sensor;
use fmu_kit::{Info, Variables};
use rexrov::ParameterError;
use rexrov::sampling::Rate;
use rexrov::sensors::{Dvl, DvlMemory, DvlParameters, DvlPing, DvlSample, DvlTruth, Instrument};
use serde::{Deserialize, Serialize};

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// True motion
    pub vehicle: DvlTruth,
    /// Switch.
    #[var(flatten)]
    pub switch: Switch,
}

/// One beam.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Beam {
    /// velocity along the beam, positive towards the seabed; 0 where it lost the bottom
    #[var(unit = "m/s")]
    pub velocity: f64,
    /// 1 with bottom lock, 0 without
    #[var(min = 0.0, max = 1.0)]
    pub valid: f64,
}

impl Beam {
    fn of(velocity: Option<f64>) -> Self {
        velocity.map_or_else(Self::default, |velocity| Self { velocity, valid: 1.0 })
    }
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Velocity.
    #[var(flatten)]
    pub sample: DvlSample,
    /// Disagreement of the four beams, with the noise of surge and sway; 0 with three
    #[var(unit = "m/s")]
    pub error_velocity: f64,
    /// Height over the seabed; 0 if none is modelled
    #[var(unit = "m")]
    pub altitude: f64,
    /// Beam towards 45, 135, 225, 315 deg from forward
    pub beam: [Beam; 4],
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

impl Sensor for Dvl {
    const INFO: Info =
        crate::info("Dvl", "Doppler velocity log with four beams, bottom lock and lever arm");
    type Parameters = DvlParameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = DvlMemory;

    fn preset(selected: &DvlParameters) -> DvlParameters {
        selected.model.parameters()
    }

    fn new(p: &DvlParameters) -> Result<Self, ParameterError> {
        Self::new(p)
    }

    fn instrument(p: &DvlParameters) -> &Instrument {
        &p.instrument
    }

    fn rate(&self) -> Rate {
        self.rate
    }

    fn memory(&self) -> DvlMemory {
        self.memory()
    }

    fn sample(&self, stamp: Stamp, memory: &mut DvlMemory, u: &Inputs) -> Option<Outputs> {
        let ping = self.sample(memory, &u.vehicle).filter(|_| u.switch.is_on())?;
        let DvlPing { sample, error_velocity, altitude, beams } = ping;
        Some(Outputs { sample, error_velocity, altitude, beam: beams.map(Beam::of), stamp })
    }
}
