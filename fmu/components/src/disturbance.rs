//! Environment: `rexrov::environment::Disturbance` with FMI variables.

use crate::groups::{Ned, Wrench, parameter_error};
use fmu_kit::{Fault, Info, ParameterError, Resources, Sample, Time, Variables};
use rexrov::environment::{self, DisturbanceMemory, DisturbanceParameters};
use serde::{Deserialize, Serialize};

/// Parameters of the disturbances.
#[derive(Clone, Debug, Variables)]
pub struct Parameters {
    /// Samples a second
    #[var(unit = "Hz", min = 0.001, max = 1e6)]
    pub rate_hz: f64,
    /// Seed of everything
    #[var(min = 0)]
    pub seed: i32,
    /// Standard deviation of surge, sway and heave force
    #[var(unit = "N", min = 0.0)]
    pub force_sigma: f64,
    /// Standard deviation of the yaw moment
    #[var(unit = "N.m", min = 0.0)]
    pub moment_sigma: f64,
    /// Standard deviation of roll and pitch moment
    #[var(unit = "N.m", min = 0.0)]
    pub tilt_moment_sigma: f64,
    /// Correlation time of forces and moments
    #[var(unit = "s", min = 1e-6)]
    pub correlation_time: f64,
    /// Current at the start
    pub mean_current: Ned,
    /// Density of the random walk of the current north and east
    #[var(unit = "m/(s2.Hz0.5)", min = 0.0, nominal = 0.001)]
    pub current_random_walk: f64,
    /// Standard deviation of the constant relative errors of the thrusts, drawn once
    #[var(unit = "1", min = 0.0)]
    pub thrust_gain_sigma: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        let p = DisturbanceParameters::default();
        Self {
            rate_hz: p.rate_hz,
            seed: i32::try_from(p.seed).unwrap_or(i32::MAX),
            force_sigma: p.force_sigma,
            moment_sigma: p.moment_sigma,
            tilt_moment_sigma: p.tilt_moment_sigma,
            correlation_time: p.correlation_time,
            mean_current: p.mean_current.into(),
            current_random_walk: p.current_random_walk,
            thrust_gain_sigma: p.thrust_gain_sigma,
        }
    }
}

/// The loss of one thruster.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Loss {
    /// fraction of the thrust that is lost
    #[var(unit = "1")]
    pub loss: f64,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, Variables)]
pub struct Outputs {
    /// Force and moment about the centre of gravity, body frame
    pub wrench: Wrench,
    /// Current of the water
    pub current: Ned,
    /// Thruster
    pub thruster: [Loss; 8],
}

/// The disturbances.
pub struct Disturbance(environment::Disturbance);

impl Sample for Disturbance {
    const INFO: Info = crate::info(
        "Disturbance",
        "Random forces, current and thrust errors that act on a vehicle",
    );
    type Parameters = Parameters;
    type Inputs = ();
    type Outputs = Outputs;
    type Memory = DisturbanceMemory;

    fn new(p: &Parameters, _: &Resources) -> Result<Self, ParameterError> {
        let parameters = DisturbanceParameters {
            rate_hz: p.rate_hz,
            seed: u64::from(p.seed.unsigned_abs()),
            force_sigma: p.force_sigma,
            moment_sigma: p.moment_sigma,
            tilt_moment_sigma: p.tilt_moment_sigma,
            correlation_time: p.correlation_time,
            mean_current: p.mean_current.into(),
            current_random_walk: p.current_random_walk,
            thrust_gain_sigma: p.thrust_gain_sigma,
        };
        environment::Disturbance::new(&parameters).map(Self).map_err(parameter_error)
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
        y: &mut Outputs,
    ) -> Result<(), Fault> {
        let sample = self.0.sample(memory);
        *y = Outputs {
            wrench: sample.wrench.into(),
            current: sample.current.into(),
            thruster: sample.thruster_loss.map(|loss| Loss { loss }),
        };
        Ok(())
    }
}
