//! Import of FMI 2.0 FMUs for co-simulation and model exchange: archive, description, library, instances.
//!
//! [`Fmu::open`] gives one shared value per file and process; [`Instance`] is the safe handle of
//! one `fmi2Component`. All `unsafe` of this crate is in `open`, `library`, `callbacks` and `instance`.

pub mod archive;
mod callbacks;
pub mod description;
mod elf;
mod fmu;
mod instance;
mod library;
mod log;
mod open;
mod status;

pub use description::{
    Causality, Description, InterfaceType, Kind, Output, Value, Variability, Variable,
};
pub use fmu::Fmu;
pub use instance::{Instance, NextEvent, Place, State, Step};
