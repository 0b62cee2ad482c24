//! Explicit Runge-Kutta methods with step-size control and event location.
//!
//! | module | contents |
//! |---|---|
//! | `tableau` | the coefficients of the methods |
//! | `step` | one step of a method, for states in slices |
//! | `control` | the norm of the error, the length of the next step |
//! | `event` | where in a step an event indicator changes its sign |
//!
//! Nothing here allocates during a step or reads a clock, and nothing knows FMI except for the
//! domains of event indicators.
#![forbid(unsafe_code)]

mod control;
mod event;
mod step;
mod tableau;

pub use control::{RootMeanSquare, step_factor};
pub use event::{Bracket, any_changed, is_positive, resolution};
pub use step::RungeKutta;
pub use tableau::{CLASSICAL, DORMAND_PRINCE, Tableau};
