//! The paper's two filters: extended Kalman filters of `[x, y, z, psi]`. The velocity comes from
//! the velocity log, the acceleration from the model or from the accelerometers.
//!
//! Measurements are fused when they arrive, once per cycle, not at their own time.

mod ekf;
mod intake;
mod memory;
mod misprinted;
mod parameters;
mod prediction;

pub use ekf::Ekf;
pub use memory::EkfMemory;
use misprinted::Misprinted;
pub use parameters::{EkfParameters, ProcessNoise, Transition};
pub use prediction::Acceleration;
