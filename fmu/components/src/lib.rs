//! The RexROV vehicle, its sensors, its state estimators and its guidance as FMI 2.0 components.
//!
//! There is one small file per component. Its parameters and most of its inputs and outputs are
//! declared where the equations are, in the crate `rexrov`. One library serves all FMUs; the GUID
//! selects the component.
//!
//! World frame NED, body frame FRD (forward, starboard, down), SI units. Array indices start at
//! zero, like the paper's thruster numbers.

#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

pub mod ahrs;
pub mod course;
pub mod disturbance;
pub mod dvl;
pub mod ekf_dynamic;
pub mod ekf_kinematic;
pub mod gps;
pub mod imu;
pub mod instrument;
pub mod nav_constant_acceleration;
pub mod nav_dynamic;
pub mod nav_inertial;
pub mod nav_model_aided;
pub mod navigation_estimate;
pub mod navigation_parameters;
pub mod navigation_ports;
pub mod navigator;
pub mod pressure;
pub mod pure_pursuit;
pub mod rexrov;
pub mod sensing;
pub mod tachometer;
pub mod velocity_controller;

use ::rexrov::sensors;
use fmu_kit::{Info, ParameterError, Sampled};
use navigator::Navigating;
use sensing::Sensing;

/// Declarations common to all components.
const fn info(name: &'static str, description: &'static str) -> Info {
    Info {
        author: "The RexROV FMI project contributors",
        version: env!("CARGO_PKG_VERSION"),
        copyright: "© 2026 the RexROV FMI project contributors",
        license: "MIT OR Apache-2.0",
        ..Info::new(name, description)
    }
}

/// An error of the mathematics as an error of a variable.
pub(crate) fn parameter_error(error: ::rexrov::ParameterError) -> ParameterError {
    ParameterError::new(error.name, format!("{}: {}", error.value, error.reason))
}

fmu_kit::export!(
    rexrov::RexRov,
    Sampled<disturbance::Disturbance>,
    Sensing<sensors::Imu>,
    Sensing<sensors::Ahrs>,
    Sensing<sensors::Dvl>,
    Sensing<sensors::Gps>,
    Sensing<sensors::PressureSensor>,
    Sensing<sensors::Tachometer>,
    Sampled<Navigating<ekf_dynamic::EkfDynamic>>,
    Sampled<Navigating<ekf_kinematic::EkfKinematic>>,
    Sampled<Navigating<nav_constant_acceleration::NavConstantAcceleration>>,
    Sampled<Navigating<nav_dynamic::NavDynamic>>,
    Sampled<Navigating<nav_inertial::NavInertial>>,
    Sampled<Navigating<nav_model_aided::NavModelAided>>,
    Sampled<pure_pursuit::PurePursuit>,
    Sampled<velocity_controller::VelocityController>,
);
