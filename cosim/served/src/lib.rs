//! What the libraries of FMUs that `cosim` writes have in common.
//!
//! The C interface, the rules what is legal when, and the log are those of `fmu-kit`; what is
//! inside ([`Inside`]) is `cosim`'s. Between them stands [`Around`], one instance.

mod around;
mod inside;

pub use around::{Around, State};
pub use inside::{Experiment, Inside};
