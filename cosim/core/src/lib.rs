//! The engine of `cosim`: systems of FMUs are read, stepped, recorded, disturbed and continued.
//!
//! The library of exported systems contains this crate and those below it; whatever such a library
//! does without is in a crate above.

#![forbid(unsafe_code)]

mod condition;
mod fault;
pub mod hosted;
pub mod master;
pub mod observe;
mod pace;
pub mod scenario;
mod signals;
mod solver;
pub mod system;
#[cfg(feature = "files")]
pub mod table;

pub use cosim_base::{Code, Error, Result, Step, Time};
pub use master::{Controls, Manipulator, Run, Snapshot, Summary};
pub use observe::{Observer, Recording};
pub use pace::{Overruns, Pace};
pub use system::{Algorithm, Input, Overrides, System};
