//! The RexROV underwater vehicle, its sensors, state estimators, guidance and control as plain
//! mathematics: no FMI, files, threads or clock. Everything is a pure function of its arguments;
//! values kept between calls are in small serialisable `...Memory` structures.
//!
//! Frames: world NED (x north, y east, z down), body FRD (x forward, y starboard, z down) with
//! the centre of gravity at its origin. Units are SI unless a name says otherwise (`_deg`, `_hz`).
//! Parameters and measurements declare their names, units, bounds and start values as quantities
//! (`fmu_quantity`); axes of vectors are in [`axes`].
//! Transcendental functions come from `libm`, so that results agree to the last bit everywhere.
#![allow(clippy::needless_range_loop, reason = "indices as the equations have them")]

pub mod allocation;
pub mod attitude;
pub mod axes;
pub mod control;
pub mod environment;
pub mod estimation;
pub mod guidance;
pub mod sampling;
pub mod sensors;
pub mod vehicle;

mod error;
mod vector;

pub use error::ParameterError;

/// The code of the README, for the tests.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
