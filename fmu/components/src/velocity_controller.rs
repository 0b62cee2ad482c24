//! Velocity control with allocation: `rexrov::control::VelocityController` with FMI variables.

use crate::groups::{Force, Inertia, Mounting, Velocity, Velocity4, Wrench, parameter_error};
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::control::{self, ControllerMemory, ControllerParameters, Pid};
use serde::{Deserialize, Serialize};

/// Gains of the three linear axes.
#[derive(Clone, Debug, Variables)]
pub struct Linear {
    /// proportional gain
    #[var(unit = "1/s", min = 0.0)]
    pub p: f64,
    /// integral gain
    #[var(unit = "1/s2", min = 0.0)]
    pub i: f64,
    /// derivative gain
    #[var(unit = "1", min = 0.0)]
    pub d: f64,
    /// limit of the demanded acceleration
    #[var(unit = "m/s2", min = 1e-9)]
    pub saturation: f64,
}

/// Gains of the three angular axes.
#[derive(Clone, Debug, Variables)]
pub struct Angular {
    /// proportional gain
    #[var(unit = "1/s", min = 0.0)]
    pub p: f64,
    /// integral gain
    #[var(unit = "1/s2", min = 0.0)]
    pub i: f64,
    /// derivative gain
    #[var(unit = "1", min = 0.0)]
    pub d: f64,
    /// limit of the demanded acceleration
    #[var(unit = "rad/s2", min = 1e-9)]
    pub saturation: f64,
}

/// Parameters of the controller.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// Cycles a second
    #[var(unit = "Hz", min = 0.001, max = 1e6)]
    pub rate_hz: f64,
    /// Surge, sway and heave
    pub linear: Linear,
    /// Roll, pitch and yaw
    pub angular: Angular,
    /// Rigid mass
    #[var(unit = "kg", min = 1e-9, nominal = 1000.0)]
    pub mass: f64,
    /// Rigid inertia about the centre of gravity, positive definite
    pub inertia: Inertia,
    /// Thruster
    pub thruster: [Mounting; 8],
    /// Limit of each thruster, either sign
    #[var(unit = "N", min = 1e-9, nominal = 1000.0)]
    pub thrust_limit: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let c = ControllerParameters::default();
        let Pid { p, i, d, saturation } = c.linear;
        let linear = Linear { p, i, d, saturation };
        let Pid { p, i, d, saturation } = c.angular;
        Self {
            rate_hz: c.rate_hz,
            linear,
            angular: Angular { p, i, d, saturation },
            mass: c.mass,
            inertia: c.inertia.into(),
            thruster: c.thrusters.map(Into::into),
            thrust_limit: c.thrust_limit,
        }
    }
}

impl From<&Parameters> for ControllerParameters {
    fn from(c: &Parameters) -> Self {
        let Linear { p, i, d, saturation } = c.linear;
        let linear = Pid { p, i, d, saturation };
        let Angular { p, i, d, saturation } = c.angular;
        Self {
            rate_hz: c.rate_hz,
            linear,
            angular: Pid { p, i, d, saturation },
            mass: c.mass,
            inertia: c.inertia.into(),
            thrusters: c.thruster.map(Into::into),
            thrust_limit: c.thrust_limit,
        }
    }
}

/// The known loss of a thruster.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Loss {
    /// fraction of its thrust that is lost (0 healthy, 1 gone)
    #[var(min = 0.0, max = 1.0)]
    pub loss: f64,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Default, Variables)]
pub struct Inputs {
    /// Velocity demanded, body frame
    pub command: Velocity4,
    /// Velocity, body frame
    pub velocity: Velocity,
    /// Thruster
    pub thruster: [Loss; 8],
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Thruster
    pub thruster: [Force; 8],
    /// Force and moment demanded, before the limits of the thrusters
    pub wrench: Wrench,
}

/// The controller.
pub struct VelocityController(control::VelocityController);

impl Sample for VelocityController {
    const INFO: Info = crate::info(
        "VelocityController",
        "PID velocity control and allocation to up to eight thrusters",
    );
    type Parameters = Parameters;
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Memory = ControllerMemory;

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        control::VelocityController::new(&p.into()).map(Self).map_err(parameter_error)
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
        y: &mut Outputs,
    ) -> Result<(), Fault> {
        let loss = u.thruster.map(|thruster| thruster.loss);
        let demand = self.0.update(memory, u.command.into(), u.velocity.into(), &loss);
        *y = Outputs {
            thruster: demand.force.map(|force| Force { force }),
            wrench: demand.wrench.into(),
        };
        Ok(())
    }
}
