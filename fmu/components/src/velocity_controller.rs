//! Velocity control with allocation: `rexrov::control::VelocityController` as a component.

use crate::parameter_error;
use fmu_kit::{Fault, Info, Member, ParameterError, Resources, Sample, Time, Variables};
use rexrov::axes;
use rexrov::control::{self, ControllerMemory, ControllerParameters, Demand};

/// The known loss of a thruster.
const LOSS: Member = Member::new("loss", "fraction of its thrust that is lost (0 healthy, 1 gone)")
    .min(0.0)
    .max(1.0);

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// Velocity demanded, body frame
    #[var(elements = axes::VELOCITY4)]
    pub command: [f64; 4],
    /// Velocity, body frame
    #[var(elements = axes::VELOCITY)]
    pub velocity: [f64; 6],
    /// Thruster
    #[var(rename = "thruster", each = LOSS)]
    pub loss: [f64; 8],
}

/// The controller.
pub struct VelocityController(control::VelocityController);

impl Sample for VelocityController {
    const INFO: Info = crate::info(
        "VelocityController",
        "PID velocity control and allocation to up to eight thrusters",
    );
    type Parameters = ControllerParameters;
    type Inputs = Inputs;
    type Outputs = Demand;
    type Memory = ControllerMemory;

    fn new(p: &ControllerParameters, _: &Resources) -> Result<Self, ParameterError> {
        control::VelocityController::new(p).map(Self).map_err(parameter_error)
    }

    fn period_s(&self) -> f64 {
        self.0.rate.period()
    }

    fn memory(&self) -> ControllerMemory {
        ControllerMemory::default()
    }

    fn sample(
        &self,
        _: Time,
        memory: &mut ControllerMemory,
        u: &Inputs,
        y: &mut Demand,
    ) -> Result<(), Fault> {
        *y = self.0.update(memory, u.command, u.velocity, &u.loss);
        Ok(())
    }
}
