//! The C interface of FMI 2.0 (`fmi2Functions.h`): the only place with `unsafe`.
//!
//! Each function here has the name and arguments of the standard's; [`export!`](crate::export)
//! gives them their unmangled symbols in the author's library. Common to all of them:
//!
//! * a component handle is a number, looked up among the live instances, so a handle that was freed
//!   or never issued is detected without touching memory;
//! * a null pointer is rejected unless the array it stands for is empty;
//! * a panic is caught, logged and ends the instance, never the importer;
//! * the floating-point environment is the default one during the call, and the importer's is
//!   restored after it.

#![allow(unsafe_code, non_snake_case, clippy::missing_safety_doc)]

mod arguments;
mod co_simulation;
mod common;
mod environment;
mod guard;
mod handles;
mod logger;
mod model_exchange;
mod resource_uri;
mod state;
mod tangent;
pub mod types;
mod values;

pub use co_simulation::*;
pub use common::*;
pub use handles::{Library, Shelf};
pub use model_exchange::*;
pub use state::*;
pub use tangent::*;
pub use values::*;
