//! The FMI 2.0 standard as data, for FMUs and for the programs that import them.
//!
//! | module | contents |
//! |---|---|
//! | `time` | instants and steps, counted in nanoseconds |
//! | `call` | functions, states, and which function is legal in which state |
//! | `status` | `fmi2Status`, `fmi2StatusKind`, log categories |
//! | `interface` | co-simulation and model exchange |
//! | `variable` | base types, causality, variability, initial |
//! | `unit` | unit expressions and base units |
//! | `xml` | writing XML |
//! | `platform` | the folders of binaries |
//!
//! Sections are those of FMI 2.0.4, unless they name another version.
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)
)]

mod call;
mod interface;
mod platform;
mod status;
mod time;
mod unit;
mod variable;
mod xml;

pub use call::{Call, Phase};
pub use interface::InterfaceType;
pub use platform::folders;
pub use status::{Category, Status, StatusKind};
pub use time::{Step, Time, TimeError};
pub use unit::{BASES, Unit};
pub use variable::{Basic, Causality, Initial, Variability};
pub use xml::{Element, Xml, escape, number};
