//! The vehicle: six degrees of freedom with eight thrusters, and the reduced four-degree model.
//!
//! ```text
//! M_RB nu' + C_RB(nu) nu + M_A nu_r' + C_A(nu_r) nu_r + (D_l + D_q |nu_r|) nu_r + g = tau
//! nu_r = nu - [R^T v_c; 0],    nu_r' = nu' + [omega x R^T v_c; 0]
//! p' = R v,    q' = 1/2 q (0, omega)
//! ```
//! Fossen (2011) ch. 6-8; eqs (5)-(26) of the paper, with its misprints corrected: added mass and
//! damping are positive matrices, so they act against acceleration and motion.

mod added_mass;
mod dynamics;
mod integrate;
mod parameters;
mod presets;
mod propulsion;
mod reduced;
mod sensitivity;
mod state;
mod tangent;

pub use dynamics::{Drive, Vehicle};
pub use parameters::{Inertia, ParameterSet, Parameters};
pub use propulsion::{Propulsion, Thruster, ThrusterMode};
pub use reduced::ReducedModel;
pub use sensitivity::Sensitivity;
pub use state::{Inputs, Outputs, State};
pub use tangent::Tangent;
