//! Import of FMI 2.0 FMUs for co-simulation and model exchange: archive, description, library,
//! instances.
//!
//! [`Fmu::open`] returns one shared value per file and process; [`Instance`] is the safe handle of
//! one `fmi2Component`; [`Logging`] defines what instances log. All `unsafe`
//! code that touches FMUs is here, in `open`, `library`, `last`, `callbacks`, `guard`, `instance`,
//! `scalar` and `temporary`; other crates have some for system calls.
//!
//! `proxy` and `scripted` are what `cosim` and the libraries of remote FMUs, and of FMUs of Python
//! classes, have in common.

pub mod archive;
#[allow(unsafe_code, reason = "what FMUs call back")]
mod callbacks;
pub mod calls;
pub mod description;
pub mod elf;
mod fmu;
#[allow(unsafe_code, reason = "what belongs to the whole process")]
pub mod guard;
#[allow(unsafe_code, reason = "calls of FMUs")]
mod instance;
#[allow(unsafe_code, reason = "a page of memory that outlives a crash")]
mod last;
#[allow(unsafe_code, reason = "libraries of FMUs")]
mod library;
mod log;
mod mailbox;
#[allow(unsafe_code, reason = "libraries of FMUs")]
mod open;
pub mod proxy;
#[allow(unsafe_code, reason = "arrays of scalars as arrays of Reals")]
mod scalar;
pub mod scripted;
pub mod status;
#[allow(unsafe_code, reason = "system calls without a safe form")]
pub mod temporary;
mod trace;

pub use description::{
    Causality, Description, InterfaceType, Kind, Output, Value, Variability, Variable,
};
pub use fmu::{Fmu, forget};
pub use fmu_standard::{Basic, Category, Phase};
#[doc(hidden)]
pub use guard::Float;
pub use guard::guard_process;
pub use instance::{Direct, DirectSteps, Unusual};
pub use instance::{Instance, NextEvent, Place};
pub use last::{LastCall, Noted};
pub use mailbox::{Mailbox, Message};
pub use scalar::Scalar;
pub use trace::{Logging, Trace};
