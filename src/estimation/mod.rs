//! State estimation: the paper's extended Kalman filters, driven by a dynamic or a kinematic model.
//!
//! State `[x, y, z, psi]` (NED), one cycle every 0.1 s. Both filters share everything but where the
//! acceleration of the prediction comes from: the reduced model's equations of motion under the
//! measured thrusts (dynamic), or the accelerometers (kinematic). Eqs (35)-(53), Algorithm 2.

mod ekf;
mod measurement;
mod parameters;
mod prediction;

pub use ekf::{Ekf, EkfMemory, Estimate};
pub use measurement::{EstimationError, Measurements, Reading};
pub use parameters::{EkfParameters, ProcessNoise, Transition};
pub use prediction::Acceleration;
