//! Environment: `rexrov::environment::Disturbance` as a component.

use crate::parameter_error;
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time};
use rexrov::environment::{self, DisturbanceMemory, DisturbanceParameters, DisturbanceSample};

/// The disturbances.
pub struct Disturbance(environment::Disturbance);

impl Sample for Disturbance {
    const INFO: Info = crate::info(
        "Disturbance",
        "Random forces, current and thrust errors that act on a vehicle",
    );
    type Parameters = DisturbanceParameters;
    type Inputs = ();
    type Outputs = DisturbanceSample;
    type Memory = DisturbanceMemory;

    fn new(p: &DisturbanceParameters, _: &Resources) -> Result<Self, ParameterError> {
        environment::Disturbance::new(p).map(Self).map_err(parameter_error)
    }

    fn period_s(&self) -> f64 {
        self.0.rate.period()
    }

    fn memory(&self) -> DisturbanceMemory {
        self.0.memory()
    }

    fn sample(
        &self,
        _: Time,
        memory: &mut DisturbanceMemory,
        (): &(),
        y: &mut DisturbanceSample,
    ) -> Result<(), Fault> {
        *y = self.0.sample(memory);
        Ok(())
    }
}
