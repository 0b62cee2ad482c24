//! Doppler velocity log: `rexrov::sensors::Dvl` with FMI variables.

use crate::groups::{LinearVelocity, Velocity, parameter_error};
use crate::instrument::{Instrument, Stamp, Switch};
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::sensors::{self, DvlMemory, DvlParameters, DvlTruth};
use serde::{Deserialize, Serialize};

/// Parameters of the velocity log.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// What all sensors have.
    #[var(flatten)]
    pub instrument: Instrument,
    /// Standard deviation of each axis
    #[var(unit = "m/s", min = 0.0)]
    pub sigma: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = DvlParameters::default();
        Self { instrument: Instrument::new(p.rate_hz, p.seed, p.position), sigma: p.sigma }
    }
}

/// True motion.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Vehicle {
    /// Velocity over ground, body frame
    pub velocity: Velocity,
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
    /// Velocity over ground at the instrument, body axes
    pub velocity: LinearVelocity,
    /// Newest sample.
    #[var(flatten)]
    pub stamp: Stamp,
}

/// The velocity log.
pub struct Dvl(sensors::Dvl);

impl Sample for Dvl {
    const INFO: Info = crate::info("Dvl", "Doppler velocity log with noise and lever arm");
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = DvlMemory;

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let parameters = DvlParameters {
            rate_hz: p.instrument.rate_hz,
            seed: p.instrument.seed(),
            position: p.instrument.mounting.into(),
            sigma: p.sigma,
        };
        sensors::Dvl::new(&parameters).map(Self).map_err(parameter_error)
    }

    fn period_s(&self) -> f64 {
        self.0.rate.period()
    }

    fn memory(&self) -> DvlMemory {
        self.0.memory()
    }

    fn sample(
        &self,
        now: Time,
        memory: &mut DvlMemory,
        u: &Inputs,
        y: &mut Outputs,
    ) -> Result<(), Fault> {
        let sample = self.0.sample(memory, &DvlTruth { nu: u.vehicle.velocity.into() });
        if u.switch.is_on() {
            *y = Outputs { velocity: sample.velocity.into(), stamp: Stamp::at(now) };
        }
        Ok(())
    }
}
