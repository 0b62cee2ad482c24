//! Disturbances besides the vehicle model, for filters that have one:
//! `rexrov::estimation::Disturbances` as FMI variables.

use fmu_kit::Variables;
use rexrov::estimation;

/// Varying forces and current.
#[derive(Clone, Copy, Debug, Variables)]
pub struct Disturbances {
    /// standard deviation of the force that varies quickly, each axis
    #[var(unit = "N", min = 0.0)]
    pub force_sigma: f64,
    /// standard deviation of the yaw moment that varies quickly
    #[var(unit = "N.m", min = 0.0)]
    pub moment_sigma: f64,
    /// correlation time of both
    #[var(unit = "s", min = 1e-6)]
    pub correlation_time: f64,
    /// density of the white force
    #[var(unit = "N/Hz0.5", min = 1e-9)]
    pub force_density: f64,
    /// density of the white yaw moment
    #[var(unit = "N.m/Hz0.5", min = 1e-9)]
    pub moment_density: f64,
    /// standard deviation of the current at the start, each axis
    #[var(unit = "m/s", min = 0.0)]
    pub current_sigma: f64,
    /// density of the random walk of the current
    #[var(unit = "m/(s2.Hz0.5)", min = 0.0, nominal = 0.001)]
    pub current_walk: f64,
}

impl From<estimation::Disturbances> for Disturbances {
    fn from(d: estimation::Disturbances) -> Self {
        Self {
            force_sigma: d.force_sigma,
            moment_sigma: d.moment_sigma,
            correlation_time: d.correlation_time,
            force_density: d.force_density,
            moment_density: d.moment_density,
            current_sigma: d.current_sigma,
            current_walk: d.current_walk,
        }
    }
}

impl From<Disturbances> for estimation::Disturbances {
    fn from(d: Disturbances) -> Self {
        Self {
            force_sigma: d.force_sigma,
            moment_sigma: d.moment_sigma,
            correlation_time: d.correlation_time,
            force_density: d.force_density,
            moment_density: d.moment_density,
            current_sigma: d.current_sigma,
            current_walk: d.current_walk,
            ..Self::default()
        }
    }
}

/// With errors of the model itself.
#[derive(Clone, Copy, Debug, Variables)]
pub struct ModelErrors {
    /// What varies.
    #[var(flatten)]
    pub disturbances: Disturbances,
    /// standard deviation of the force that varies slowly, each axis: errors of damping and thrust
    #[var(unit = "N", min = 0.0)]
    pub slow_force_sigma: f64,
    /// correlation time of the force that varies slowly
    #[var(unit = "s", min = 1e-6)]
    pub slow_force_time: f64,
    /// relative error of the forces that thrusters make
    #[var(unit = "1", min = 0.0)]
    pub thrust_error: f64,
}

impl Default for ModelErrors {
    fn default() -> Self {
        let d = estimation::Disturbances::default();
        Self {
            disturbances: d.into(),
            slow_force_sigma: d.slow_force_sigma,
            slow_force_time: d.slow_force_time,
            thrust_error: d.thrust_error,
        }
    }
}

impl From<ModelErrors> for estimation::Disturbances {
    fn from(e: ModelErrors) -> Self {
        Self {
            slow_force_sigma: e.slow_force_sigma,
            slow_force_time: e.slow_force_time,
            thrust_error: e.thrust_error,
            ..e.disturbances.into()
        }
    }
}
