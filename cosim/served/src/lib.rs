//! Common parts of the libraries of FMUs that `cosim` writes.
//!
//! `fmu-kit` provides the C interface, the rules for legal calls, and the log; the inner
//! implementation ([`Inside`]) is `cosim`'s. [`Around`] connects them: one instance.

mod around;
mod inside;

pub use around::{Around, State};
pub use inside::{Experiment, Inside};
