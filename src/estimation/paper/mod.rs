//! The paper's two filters: extended Kalman filters of `[x, y, z, psi]`, whose velocity is that of
//! the velocity log, and whose acceleration comes from the model or from the accelerometers.
//!
//! What they measure is taken when it comes, once a cycle; nothing is put in its place in time.

mod ekf;
mod intake;
mod memory;
mod misprinted;
mod parameters;
mod prediction;

pub use ekf::Ekf;
pub use memory::EkfMemory;
pub use misprinted::Misprinted;
pub use parameters::{EkfParameters, ProcessNoise, Transition};
pub use prediction::Acceleration;
