//! What an instance needs of the thing it simulates: the seam between the FMI rules and the
//! mathematics.
//!
//! [`Component`](crate::Component)s get here through
//! [`ComponentModel`](super::adapter::ComponentModel). Anything else that has a variable table and
//! can be stepped (a whole system, a proxy of a remote one) would implement this trait directly.

use crate::author::{Fault, ParameterError, Time};

use super::values::{Explicit, Values};

/// A model that works on the flat values of an instance; object safe.
///
/// The instance calls [`configure`](Model::configure) first, then
/// [`initialize`](Model::initialize), then anything.
pub trait Model: Send {
    /// Gives the parameters nobody set their values, checks all, derives constants.
    ///
    /// # Errors
    /// Names the parameter that is wrong.
    fn configure(&mut self, values: &mut Values, explicit: &Explicit)
    -> Result<(), ParameterError>;

    /// Sets the states at the start time from parameters and inputs.
    ///
    /// # Errors
    /// Why the simulation cannot start.
    fn initialize(&mut self, start: Time, values: &mut Values) -> Result<(), Fault>;

    /// Computes the outputs at `t` seconds.
    fn outputs(&self, t: f64, values: &mut Values);

    /// Computes the derivatives at `t` seconds.
    fn derivatives(&self, t: f64, values: &mut Values);

    /// The next time event, if there is one.
    fn next_event(&self) -> Option<Time>;

    /// Handles the time events due at `now`; returns how many there were.
    ///
    /// # Errors
    /// Why the simulation cannot go on.
    fn events(&mut self, now: Time, values: &mut Values) -> Result<usize, Fault>;

    /// Co-simulation: advances from `t` by `h` seconds with inputs held, and computes the outputs
    /// there; returns how many events there were.
    ///
    /// # Errors
    /// Why the simulation cannot go on.
    fn step(&mut self, t: f64, h: f64, values: &mut Values) -> Result<usize, Fault>;
}
